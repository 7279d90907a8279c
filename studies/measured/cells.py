"""Cells of a table: numbers with any marks, words for a missing number or one over range, and clock times."""

import datetime
import re
from collections.abc import Iterable
from math import isfinite

from apesim.quantities import InvalidValue, quoted

MISSING = frozenset({"", "-", "--", "nan", "-nan", "n/a", "na", "#n/a", "null", "none", "1.#ind", "-1.#ind", "1.#qnan"})
"""Cells without a number, in small letters."""
OVER_RANGE = frozenset(
    {"∞", "inf", "infinity", "1.#inf", "over", "overflow", "overload", "overrange", "over range", "over-range"}
    | {"ovl", "ovld", "ovf", "ovrng", "ofl", "o.l", "o.l.", "ol", "under", "underflow", "underrange", "ufl", "#div/0!"}
)
"""Cells of a number beyond the range of the instrument, in small letters and without a sign."""
LIKE_OVER_RANGE = re.compile(r"∞|inf|over|under|ovl|ovf|ofl|o\.l|range|clip|satur|#div", re.IGNORECASE)
"""Parts of a word, stated to be a missing one, that says that a number is over range."""
SCPI_OVER_RANGE, SCPI_MISSING = 9.9e37, 9.91e37
"""Numbers that instruments write for infinity and for none, SCPI 1999, volume 1, section 7.2.1."""
ANY_NUMBER = re.compile(r"[+-]?(?:[0-9][0-9.,']*|[.,][0-9]+)(?:[eE][+-]?[0-9]+)?")
"""A number with any marks."""
DATE = r"(?P<year>[0-9]{4})[-/.](?P<month>[0-9]{1,2})[-/.](?P<day>[0-9]{1,2})"
GERMAN_DATE = r"(?P<day_>[0-9]{1,2})\.(?P<month_>[0-9]{1,2})\.(?P<year_>[0-9]{4})"
OTHER_DATE = r"(?P<other>[0-9]{1,2}[/-][0-9]{1,2}[/-](?:[0-9]{4}|[0-9]{2}))"
ANY_DATE = re.compile(f"(?:{DATE}|{GERMAN_DATE}|{OTHER_DATE})")
"""A date; in the last form day and month may be either."""
CLOCK = re.compile(
    rf"(?:{ANY_DATE.pattern}(?:T|\s+))?(?:(?P<hours>[0-9]{{1,2}}):)?(?P<minutes>[0-9]{{1,2}}):"
    r"(?P<seconds>[0-9]{2})(?P<part>[.,][0-9]{1,12})?\s*(?P<half>[AaPp])?(?(half)\.?[Mm]\.?)(?:Z|[+-][0-9]{2}:?[0-9]{2})?"
)
"""Clock time with seconds: behind a date or not, with a part of a second or not."""
HOURS_MINUTES = re.compile(rf"(?:{ANY_DATE.pattern}(?:T|\s+))?[0-9]{{1,2}}:[0-9]{{2}}(?:\s*[AaPp]\.?[Mm]\.?)?")
"""Clock time without seconds, or minutes and seconds."""
DAY = 86400.0
"""Length of a day [s]."""


def is_missing(cell: str) -> bool:
    """Tell whether a cell says that there is no number.

    >>> is_missing("NaN"), is_missing("#N/A"), is_missing(""), is_missing("0")
    (True, True, True, False)
    """
    return cell.lower() in MISSING


def is_over_range(cell: str) -> bool:
    """Tell whether a cell says that a number is beyond the range of the instrument.

    >>> is_over_range("-1.#INF"), is_over_range("OVER"), is_over_range("9.9"), is_over_range("none")
    (True, True, False, False)
    """
    return cell.lower().removeprefix("-").removeprefix("+") in OVER_RANGE


def is_clock(cell: str) -> bool:
    """Tell whether a cell is a clock time, be it without seconds.

    >>> [is_clock(cell) for cell in ("2026-03-01 12:00:00.123", "12:00:00,123", "00:01.5", "12:00")]
    [True, True, True, True]
    """
    return bool(CLOCK.fullmatch(cell) or HOURS_MINUTES.fullmatch(cell))


def is_word(cell: str) -> bool:
    """Tell whether a cell is known not to be several numbers: missing, over range, a date, a clock time or no digit.

    >>> [is_word(cell) for cell in ("OVER", "1.#INF", "12:00:00", "2026-03-01", "valve opened", "0.5;1")]
    [True, True, True, True, True, False]
    """
    is_known = is_missing(cell) or is_over_range(cell) or is_clock(cell) or ANY_DATE.fullmatch(cell)
    return bool(is_known) or not re.search("[0-9]", cell)


class Clock:
    """Reader of the clock times of a column, in seconds since the midnight before the first of them."""

    def __init__(self) -> None:
        self.first_day: int | None = None
        self.date = ""
        self.last, self.nights = 0.0, 0

    def read(self, cell: str) -> float:
        """Read a clock time, see `is_clock`, in seconds since the midnight before the first one read [s].

        Raises InvalidValue where there is no such day or time, or the order of its day and month would count.

        >>> clock = Clock()
        >>> clock.read("2026-03-01 23:59:59.5"), clock.read("2026-03-02 00:00:00.5")
        (86399.5, 86400.5)
        """
        found = CLOCK.fullmatch(cell)
        if not found or not (found["hours"] or found["part"]):
            right = "give hours, minutes and seconds in every cell, e.g. 12:00:00.123"
            raise InvalidValue(f"{quoted(cell)} is no clock time", right)
        hours, minutes = int(found["hours"] or 0), int(found["minutes"])
        if found["half"]:
            hours = hours % 12 + 12 * (found["half"] in "pP")
        seconds = float(found["seconds"] + (found["part"] or "").replace(",", "."))
        if hours > 24 or minutes > 59 or seconds >= 61.0:
            raise InvalidValue(f"{quoted(cell)} is no clock time", "give hours, minutes and seconds")
        seconds += 3600.0 * hours + 60.0 * minutes
        return DAY * self._count_days(cell, found, seconds) + seconds

    def _count_days(self, cell: str, found: re.Match[str], seconds: float) -> int:
        """Days since that of the first cell; without a date one more where the time falls back by half a day."""
        if found["other"]:
            self.date = self.date or found["other"]
            if found["other"] != self.date:
                right = "write dates as 2026-03-01"
                raise InvalidValue(f"the date changes in {quoted(cell)}: which is the day, which the month?", right)
        parts = [found[name] or found[f"{name}_"] for name in ("year", "month", "day")]
        if not all(parts):
            self.nights += seconds < self.last - 0.5 * DAY
            self.last = seconds
            return self.nights
        try:
            day = datetime.date(*map(int, parts)).toordinal()
        except ValueError:
            raise InvalidValue(f"there is no such day as in {quoted(cell)}", "write dates as 2026-03-01") from None
        self.first_day = day if self.first_day is None else self.first_day
        return day - self.first_day


def split_stated(words: Iterable[str]) -> tuple[frozenset[str], frozenset[float]]:
    """Split the words that a user states to be missing into texts, in small letters, and numbers."""
    texts, numbers = set(), set()
    for word in words:
        try:
            numbers.add(float(word.replace(",", ".")))
        except ValueError:
            texts.add(word.lower())
    return frozenset(texts), frozenset(number for number in numbers if isfinite(number))
