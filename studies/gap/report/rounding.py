"""Numbers as text, with no more digits than their error leaves."""

from collections.abc import Sequence
from math import ceil, floor, isfinite, log10, sqrt

NORMAL_95 = 1.959963984540054
"""Half the width of a 95 % interval of a standard normal number: its quantile at 0.975."""
MAX_DIGITS = 6
"""Significant digits at most, however small the error is: nobody reads more."""
UNKNOWN_ERROR_DIGITS = 2
"""Significant digits of a number whose error is not known."""


def round_to_error(value: float, error: float | None) -> str:
    """A number as text; its last digit is the first digit of its standard deviation.

    `error` is in the unit of the value; None: it is not known, and two digits are shown.

    >>> round_to_error(0.7974, 0.0022), round_to_error(1234.5, 60.0), round_to_error(3.14159, None)
    ('0.797', '1230', '3.1')
    """
    if not isfinite(value) or value == 0.0:
        return f"{value:g}"
    if error is None or not isfinite(error) or error <= 0.0:
        return _write(value, _find_place(value) + 1 - UNKNOWN_ERROR_DIGITS)
    return _write(value, max(_find_place(error), _find_place(value) + 1 - MAX_DIGITS))


def find_error(value: float, interval: Sequence[float] | None, open_ends: Sequence[str]) -> float | None:
    """The standard deviation, in the unit of the value, that a 95 % interval stands for; None where it is not known.

    `interval` is None where it was not sought; `open_ends` name the sides, "low" and "high", on which the data hold
    nothing.
    """
    if interval is None or len(open_ends) == len(interval):
        return None
    low, high = interval
    if not open_ends:
        return (high - low) / (2.0 * NORMAL_95) or None
    held = high if "low" in open_ends else low
    return abs(held - value) / NORMAL_95 or None


def format_size(rms: float, samples: int) -> str:
    """A root mean square over the noise as text: the noise of n samples scatters by 1 / sqrt(2 n)."""
    return f"{rms:.{min(2, max(0, ceil(log10(2.0 * max(samples, 1)) / 2.0)))}f}"


def format_sigmas(value: float, *, signed: bool = False) -> str:
    """A number of sigmas of the noise as text: a whole number, as noise alone moves it by about one.

    `signed` writes a plus.
    """
    whole = round(value)
    return f"{whole:+d}" if signed and whole else str(whole)


def format_chance(p_value: float, draws: int) -> str:
    """A chance that was counted in random draws, as text; below 1 in 10 000 only that is said."""
    if p_value < 1e-4:
        return "below 0.0001"
    error = sqrt(p_value * max(1.0 - p_value, 1.0 / draws) / draws)
    return _write(p_value, max(_find_place(error), _find_place(p_value) + 1 - UNKNOWN_ERROR_DIGITS))


def _find_place(value: float) -> int:
    """Power of ten of the first digit of a number."""
    return floor(log10(abs(value)) + 1e-9)


def _write(value: float, place: int) -> str:
    """A number rounded to a power of ten, without an exponent where it is of usual size."""
    rounded = round(value, -place)
    if rounded == 0.0:
        return "0"
    if not -5 <= _find_place(rounded) <= MAX_DIGITS:
        return f"{rounded:.{max(0, _find_place(rounded) - place)}e}"
    return f"{rounded:.{max(0, -place)}f}"
