"""Declarations: what a parameter may be, with its unit, range and source."""

import math
import re
from dataclasses import dataclass
from functools import cached_property
from numbers import Integral, Real
from typing import Any

from apesim.quantities.input_errors import InvalidValue, quoted
from apesim.quantities.old_names import warn_of_old_name
from apesim.quantities.units import MAX_TEXT, NUMBER, respelt, si_value, unit

DECIMAL_COMMA = r"(?<=[0-9]),(?=[0-9])"
SLIPS = (
    (DECIMAL_COMMA, "."),
    (r"(?<=[0-9]|\s)((?:bar|psi|[kMh]?Pa))\s*(?:g|\(g\))$", r"\1 gauge"),
    (r"(?<=[0-9]|\s)((?:bar|psi|[kMh]?Pa))\s*(?:a|\(a\))$", r"\1 abs"),
    (r"(?<=[0-9])\s*[CF]$", lambda found: f" deg{found[0].strip()}"),
)
"""How a quantity is often written elsewhere, and how here: 0,9; barg; bar(a); 20 C."""
MAX_SLIP = 60
"""Characters of a text in which a slip is looked for: a longer one is no quantity."""
ROUNDING = 1e-12
"""Relative error by which a value computed in SI may miss an end of its range."""


class Declaration:
    """What a parameter may be: base of quantities, choices and curves.

    A declaration stands in the annotation of a field of a parameter class. Its ``read`` takes what a user wrote to the
    value inside, ``check`` refuses a wrong value that was made in Python, and ``render`` writes the text that reads
    back as the value. pydantic reads a field with ``read``.
    """

    is_table = False
    """Whether it is a table of texts, or an array of tables, whose keys are no keys of the tree."""
    is_array = False
    """Whether it is an array of tables, see `apesim.quantities.overrides`."""
    entry = ""
    """A right entry of such a table in TOML."""
    is_gauge = False
    """Whether it is a pressure that is shown above the ambient pressure."""

    def convert(self, value: Any) -> Any:
        """Return a checked value in the type that the kernels are compiled for.

        Parameters
        ----------
        value : object
            Value inside, which ``check`` takes.

        Returns
        -------
        object
            The same value; the very object where its type is right.

        Examples
        --------
        >>> from fractions import Fraction
        >>> Quantity("mm", 1, 50, "chosen").convert(Fraction(1, 100)), Choice(("a", "b"), "chosen").convert(1)
        (0.01, 1)
        """
        return self._converted(value)

    def _converted(self, value: Any) -> Any:
        """Convert a checked value, see `convert`."""
        raise NotImplementedError

    def __get_pydantic_core_schema__(self: Any, source: Any, handler: Any) -> Any:
        from pydantic_core import core_schema

        def validate(raw: Any, info: Any) -> Any:
            return self.read(raw, **info.context)

        return core_schema.with_info_plain_validator_function(validate)


@dataclass(frozen=True)
class Quantity(Declaration):
    """A number with a unit; inside a float in SI.

    Parameters
    ----------
    unit : str
        The unit it is printed in; "" for a dimensionless number, which is written bare.
    low, high : float
        The range in that unit, ends included. Where `high` is `math.inf`, the text "inf" is allowed.
    source : str
        Where the default comes from.
    typical : str
        A usual value, shown as a right form where no default is at hand; "": an end of the range.
    text : str, optional
        What holds if an optional value is not given.
    optional : bool
        NaN inside means not given, "" in a file.
    whole : bool
        A number of things.
    """

    unit: str
    low: float
    high: float
    source: str
    text: str | None = None
    optional: bool = False
    whole: bool = False
    typical: str = ""

    suffix = ""

    @cached_property
    def range_text(self) -> str:
        """Text of the range, such as "1 to 50 mm"."""
        low, high = (repr(float(end)).removesuffix(".0") for end in (self.low, self.high))
        if math.isinf(self.high):
            ends = "any number" if math.isinf(self.low) else f"at least {low}"
        else:
            ends = f"at most {high}" if math.isinf(self.low) else f"{low} to {high}"
        return f"{ends} {self.unit}{self.suffix}".strip() + ", whole" * self.whole

    @cached_property
    def needs_unit(self) -> bool:
        """Whether it is an angle or a speed of rotation: a bare number of these does not tell its unit."""
        return unit(self.unit).dimension in (unit("rad").dimension, unit("rad/s").dimension)

    @cached_property
    def ends(self) -> list[float]:
        """Lower and upper end of the range in SI."""
        scale = unit(self.unit)
        return [end if math.isinf(end) else scale.si(repr(float(end))) for end in (self.low, self.high)]

    @cached_property
    def _ends_rounded(self) -> tuple[float, float]:
        """Lower and upper end of the range in SI, each with room for `ROUNDING`."""
        low, high = (end + sign * ROUNDING * abs(end) for end, sign in zip(self.ends, (-1.0, 1.0), strict=True))
        return low, high

    def read(self, raw: Any, ambient_pressure: float | None = None, folder: Any = None) -> float:
        """Return the value in SI of what a user wrote.

        Parameters
        ----------
        raw : str, float or int
            Text with its unit; a number only where the quantity has no unit.
        ambient_pressure : float, optional
            Pressure that gauge pressures stand above [Pa, absolute].
        folder : path, optional
            Unused.

        Returns
        -------
        float
            Value in SI; NaN where an optional one is not given.

        Raises
        ------
        InvalidValue
            It is no number, has no unit or one of another dimension, or is out of range; names the right spelling
            where that can be told.

        Examples
        --------
        >>> stroke = Quantity("mm", 1, 50, "chosen")
        >>> stroke.read("0.9 cm")
        0.009
        >>> stroke.read("0,9 cm")
        Traceback (most recent call last):
        ...
        apesim.quantities.input_errors.InvalidValue: ("'0,9 cm': ',9 cm' is no known unit", 'write "0.9 cm"')
        """
        try:
            return self._read(raw, ambient_pressure)
        except InvalidValue as wrong:
            raise self._meant(raw, ambient_pressure, wrong) or wrong from None

    def _meant(self, raw: Any, ambient_pressure: float | None, wrong: InvalidValue) -> InvalidValue | None:
        """The `InvalidValue` of a text with a slip, its remedy the right spelling; else None.

        Parameters
        ----------
        wrong : InvalidValue
            What is wrong with the text.
        """
        if not isinstance(raw, str) or len(raw) > MAX_SLIP or wrong.right:
            return None
        meant = raw.strip()
        for slip, spelling in SLIPS:
            meant = re.sub(slip, spelling, meant)
        meant = respelt(meant)
        if meant == raw.strip():
            return None
        try:
            self._read(meant, ambient_pressure)
        except InvalidValue as still:
            return InvalidValue(still.wrong, still.right) if still.right else None
        return InvalidValue(wrong.wrong, f"write {self._toml(meant)}")

    def _read(self, raw: Any, ambient_pressure: float | None) -> float:
        """The SI value of a text that is spelt as it is due here; raises `InvalidValue`."""
        if isinstance(raw, bool) or not isinstance(raw, str | int | float):
            raise InvalidValue(f"{quoted(raw)} is no {'quantity' if self.unit else 'number'}")
        try:
            text = raw.strip() if isinstance(raw, str) else repr(float(raw))
        except OverflowError:
            raise InvalidValue(f"{quoted(raw)} is too large") from None
        if len(text) > MAX_TEXT:
            what = "finite number" + " with a unit" * bool(self.unit)
            raise InvalidValue(f"{quoted(raw)} is no {what}: it has {len(text)} characters, {MAX_TEXT} are read")
        if self.unit and (re.fullmatch(NUMBER, text) or not isinstance(raw, str)):
            raise InvalidValue(f"{quoted(raw)} has no unit", self._with_unit(text))
        if self.optional and not text:
            return math.nan
        if text == "inf" and self.high == math.inf:
            return math.inf
        value = self._value(raw, text, ambient_pressure)
        if not self.ends[0] <= value <= self.ends[1]:
            raise InvalidValue(f"{quoted(raw)} is out of range", f"allowed: {self.range_text}")
        if self.whole and not value.is_integer():
            raise InvalidValue(f"{quoted(raw)} is no whole number", f"write {math.floor(value)} or {math.ceil(value)}")
        return value

    def _value(self, raw: Any, text: str, ambient_pressure: float | None) -> float:
        return si_value(raw, text, self.unit)

    def as_said(self, value: float) -> float:
        """Give a number of a caller the type that a text of it would have.

        Parameters
        ----------
        value : float
            Number in SI.

        Returns
        -------
        float
            The same number.

        Examples
        --------
        >>> Quantity("mm", 1, 50, "chosen").as_said(9e-3)
        0.009
        """
        return value

    def _with_unit(self, number: str) -> str:
        """A bare number in a right form; "" if that is out of range."""
        form = f"{number.removesuffix('.0')} {self.unit}"
        try:
            self.read(f"{form}{self.suffix}")
        except InvalidValue:
            return ""
        return f'write "{form} gauge" or "{form} abs"' if self.suffix else f'write e.g. "{form}"'

    def check(self, value: Any) -> None:
        """Refuse a value in SI, made in Python, whose text `read` would refuse.

        Parameters
        ----------
        value : float or int
            Value in SI; it may miss an end of the range by the relative error `ROUNDING`.

        Raises
        ------
        InvalidValue
            It is no number, is out of range, or is not whole where it has to be.

        Examples
        --------
        >>> Quantity("mm", 1, 50, "chosen").check(9e-3)
        >>> Quantity("mm", 1, 50, "chosen").check(9.0)
        Traceback (most recent call last):
        ...
        apesim.quantities.input_errors.InvalidValue: ('9000 mm is out of range', 'allowed: 1 to 50 mm')
        """
        low, high = self._ends_rounded
        if type(value) is float and low <= value <= high and not self.whole:  # as nearly all are
            return
        if isinstance(value, bool) or not isinstance(value, Real):
            raise InvalidValue(f"{quoted(value)} is no number", f"give a float in SI, {self.range_text}")
        if not low <= value <= high and not (self.optional and math.isnan(value)):  # type: ignore[operator]
            raise InvalidValue(f"{self._shown(value)} is out of range", f"allowed: {self.range_text}")
        if self.whole and not float(value).is_integer():
            raise InvalidValue(
                f"{self._shown(value)} is no whole number", f"give {math.floor(value)} or {math.ceil(value)}"
            )

    def _converted(self, value: Any) -> float:
        """Convert a checked value to a float, see `Declaration.convert`."""
        return value if type(value) is float else float(value)

    def _shown(self, value: Any) -> str:
        return self.render(float(value)) if math.isfinite(value) else repr(float(value))

    def render(self, value: float, ambient_pressure: float | None = None) -> str:
        """Return the shortest text that reads back as a value.

        Parameters
        ----------
        value : float
            Value in SI.
        ambient_pressure : float, optional
            Unused.

        Returns
        -------
        str
            Number with the unit of the declaration; "" for NaN, "inf" for infinity.

        Examples
        --------
        >>> Quantity("mm", 1, 50, "chosen").render(9e-3)
        '9 mm'
        """
        value = self.convert(value)
        if math.isnan(value):
            return ""
        return "inf" if value == math.inf else f"{unit(self.unit).shortest(value)} {self.unit}".strip()

    def example(self, value: float, ambient_pressure: float | None = None) -> str:
        """Return a right form for a message: that of a value, if it is one to show, or of an end of the range.

        Parameters
        ----------
        value : float
            Value in SI.
        ambient_pressure : float, optional
            Pressure that gauge pressures stand above [Pa, absolute].

        Returns
        -------
        str
            Words and text in TOML.

        Examples
        --------
        >>> print(Quantity("mm", 1, 50, "chosen").example(float("nan")))
        write e.g. "50 mm"
        """
        if not math.isfinite(value) and self.typical:
            return f"write e.g. {self._toml(self.typical)}"
        if not math.isfinite(value):
            value = next((end for end in self.ends[::-1] if math.isfinite(end)), 1.0)
        return f"write e.g. {self._toml(self.render(value, ambient_pressure))}"

    @property
    def strong(self) -> str:
        """A right form in TOML that does not stand for nothing: the upper end of the range, if it has one."""
        ends = self.high, 1.0, self.low, -1.0
        right = [end for end in ends if end and math.isfinite(end) and self.low <= end <= self.high]
        return self._toml(self.render(unit(self.unit).si(repr(float((right or ends)[0])))))

    def _toml(self, text: str) -> str:
        return f'"{text}"' if self.unit else text


class AbsolutePressure(float):
    """A pressure that was said as absolute where others are said as gauge [Pa abs].

    It stays where it is when the ambient pressure changes; a plain float there moves with it.
    """

    __slots__ = ()


@dataclass(frozen=True, init=False)
class Pressure(Quantity):
    """A pressure, absolute inside; its text says ``gauge`` (above the machine's ambient pressure) or ``abs``.

    Where it is shown as gauge, one that is said as absolute, or as a number, is an `AbsolutePressure` inside, which is
    printed as absolute.

    Parameters
    ----------
    low, high : float
        The range in `unit`, absolute.
    source, unit, text, optional, typical
        As in `Quantity`.
    show : {"abs", "gauge", "ambient"}
        How it is printed. Gauge pressures stand above the ambient one, which itself is absolute alone.
    """

    show: str = "abs"

    suffix = " abs"

    @property
    def is_gauge(self) -> bool:  # type: ignore[override]
        """Whether it is shown above the ambient pressure, unless it was said as absolute."""
        return self.show == "gauge"

    def __init__(
        self,
        low: float,
        high: float,
        source: str,
        unit: str = "MPa",
        show: str = "abs",
        text: str | None = None,
        optional: bool = False,
        typical: str = "",
    ) -> None:
        super().__init__(unit, low, high, source, text, optional, typical=typical)
        object.__setattr__(self, "show", show)

    def _value(self, raw: Any, text: str, ambient_pressure: float | None) -> float:
        body, _, kind = text.rpartition(" ")
        if kind not in ("gauge", "abs"):
            si_value(raw, text, self.unit)  # an unreadable number or unit comes first
            if self.show == "ambient":
                raise InvalidValue(f"{quoted(raw)} does not say abs", f'write "{text} abs"')
            raise InvalidValue(f"{quoted(raw)} says neither gauge nor abs", f'write "{text} gauge" or "{text} abs"')
        if kind == "abs":
            return self.as_said(si_value(raw, body.strip(), self.unit))
        if self.show == "ambient":
            wrong = f"{quoted(raw)}: gauge pressures stand above this one, which is absolute"
            raise InvalidValue(wrong, f'write "{body.strip()} abs"')
        if ambient_pressure is None:
            raise InvalidValue(f"{quoted(raw)}: no ambient pressure is known here to stand above")
        return si_value(raw, body.strip(), self.unit, ambient_pressure)

    def _converted(self, value: Any) -> float:
        """Convert a checked value to a float, see `Declaration.convert`; what was said as absolute stays so."""
        return value if isinstance(value, AbsolutePressure) else super()._converted(value)

    def as_said(self, value: float) -> float:
        """Mark a pressure as said as absolute, where others are said as gauge.

        Parameters
        ----------
        value : float
            Pressure [Pa abs].

        Returns
        -------
        float
            `AbsolutePressure` where pressures are shown as gauge.

        Examples
        --------
        >>> supply = Pressure(0.1, 2, "chosen", show="gauge")
        >>> supply.render(supply.as_said(5e5), ambient_pressure=1e5)
        '0.5 MPa abs'
        """
        return AbsolutePressure(value) if self.is_gauge and math.isfinite(value) else value

    def render(self, value: float, ambient_pressure: float | None = None) -> str:
        """Return the shortest text that reads back as a pressure.

        Parameters
        ----------
        value : float
            Pressure [Pa, absolute].
        ambient_pressure : float, optional
            Pressure that a gauge pressure is printed above [Pa, absolute]; without one it is printed as absolute.

        Returns
        -------
        str
            Number with its unit and "gauge" or "abs"; "" for NaN, "inf" for infinity.

        Examples
        --------
        >>> supply = Pressure(0.1, 2, "chosen", show="gauge")
        >>> supply.render(501325.0, ambient_pressure=101325.0), supply.render(501325.0)
        ('0.4 MPa gauge', '0.501325 MPa abs')
        """
        value = self.convert(value)
        if not math.isfinite(value):
            return super().render(value)
        is_absolute = isinstance(value, AbsolutePressure) or not self.is_gauge
        reference = None if is_absolute else ambient_pressure
        number = unit(self.unit).shortest(value, reference or 0.0)
        return f"{number} {self.unit} {'abs' if reference is None else 'gauge'}"


@dataclass(frozen=True)
class Choice(Declaration):
    """One of several words; inside its index.

    Parameters
    ----------
    options : tuple of str
        Words, in the order of their indices.
    source : str
        Where the default comes from.
    old_names : tuple of (str, str, str)
        Words of older files, each with the option that it is read as, and what is different today.
    """

    options: tuple[str, ...]
    source: str
    old_names: tuple[tuple[str, str, str], ...] = ()

    @property
    def range_text(self) -> str:
        """The words, quoted."""
        *others, last = (f'"{option}"' for option in self.options)
        return f"{', '.join(others)} or {last}" if others else last

    def read(self, raw: Any, ambient_pressure: float | None = None, folder: Any = None) -> int:
        """Return the index of the word that a user wrote.

        Parameters
        ----------
        raw : object
            Word; spaces around it do not count.
        ambient_pressure : float, optional
            Unused.
        folder : path, optional
            Unused.

        Returns
        -------
        int
            Index of the word, from 0.

        Raises
        ------
        InvalidValue
            It is none of the words.

        Examples
        --------
        >>> Choice(("epv", "cam"), "chosen").read("cam")
        1
        """
        text = raw.strip() if isinstance(raw, str) else raw
        for old, new, reason in self.old_names:
            if text == old:
                warn_of_old_name(old, new, reason)
                text = new
        if text not in self.options:
            raise InvalidValue(f"{quoted(raw)} is no option", f"write {self.range_text}")
        return self.options.index(text)

    def check(self, value: Any) -> None:
        """Refuse what is no index of a word.

        Parameters
        ----------
        value : int
            Index of a word, from 0.

        Raises
        ------
        InvalidValue
            It is no whole number, or no word has it.

        Examples
        --------
        >>> Choice(("epv", "cam"), "chosen").check(1)
        >>> Choice(("epv", "cam"), "chosen").check(2)
        Traceback (most recent call last):
        ...
        apesim.quantities.input_errors.InvalidValue: ('2 is no option', 'give one of 0 ("epv"), 1 ("cam")')
        """
        if isinstance(value, bool) or not isinstance(value, Integral) or not 0 <= value < len(self.options):  # type: ignore[operator]
            indices = ", ".join(f'{index} ("{option}")' for index, option in enumerate(self.options))
            raise InvalidValue(f"{quoted(value)} is no option", f"give one of {indices}")

    def _converted(self, value: Any) -> int:
        """Convert a checked index to an int, see `Declaration.convert`."""
        return value if type(value) is int else int(value)

    @property
    def strong(self) -> str:
        """A right form in TOML: the last of the words, as the first often stands for nothing."""
        return f'"{self.options[-1]}"'

    def render(self, value: int, ambient_pressure: float | None = None) -> str:
        """Return the word that an index stands for.

        Parameters
        ----------
        value : int
            Index, from 0.
        ambient_pressure : float, optional
            Unused.

        Returns
        -------
        str
            Word.

        Examples
        --------
        >>> Choice(("epv", "cam"), "chosen").render(1)
        'cam'
        """
        return self.options[value]
