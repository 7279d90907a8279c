"""Results: what a study hands on, numbers and traces that know their names and units.

A study makes its result class like this. The function computes, and gives every number its name, unit and meaning;
the class says which numbers come first, and draws where there is something to draw::

    from typing import ClassVar

    from apesim.results import Result, Scalar, Trace, scalars_of
    from apesim.studies.drawing.axes import axes_for, in_house_style  # imports no matplotlib before it draws


    class LeakTest(Result):
        '''One leak test.'''

        title: ClassVar[str] = "leak test"
        headline: ClassVar[tuple[str, ...]] = ("leak_area_mm2", "end_pressure")

        @in_house_style
        def plot(self, ax=None):
            '''Pressure over time; returns the axes.'''
            ax = axes_for(ax)
            ax.plot(self.traces["time"], self.traces["pressure"])
            return ax


    LeakTest(
        scalars=scalars_of(
            {"leak_area_mm2": 0.3, "end_pressure_Pa": 4.1e5},
            {"leak_area_mm2": ("mm^2", "area of the leak"), "end_pressure_Pa": ("Pa abs", "pressure at the end")},
        ),
        traces={
            "time": Trace(("time",), times, "s", "time"),
            "pressure": Trace(("time",), pressures, "Pa abs", "pressure of the vessel"),
        },
        conditions={"volume": "0.3 L"},
    )

One rule for names: a name without a unit is in SI, and what is not in SI says its unit: ``brake_torque``,
``peak_lift``, but ``speed_rpm``, ``valve_open_deg``, ``specific_air_kg_per_kWh``. JSON and archives write the SI unit
behind the name, too (``brake_torque_Nm``); a result understands both.
"""

import difflib
import html
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from apesim.late_text import LateText

if TYPE_CHECKING:
    import pandas
    import xarray

SI_SUFFIXES = ("_Nm", "_kg_per_cycle", "_m_s", "_Pa", "_kg", "_K", "_W", "_J", "_s", "_m")
"""How JSON and archives write an SI unit behind a name; longer ones first, as "_m_s" ends in "_s"."""
UNIT_SUFFIXES = {"deg": "_deg", "r/min": "_rpm", "Hz": "_hz"}
"""How a name says a unit that is not SI."""
SPARKS = 120
"""Numbers of a trace that its small picture in a notebook shows."""
MAX_HEADLINES = 6
"""Numbers in a short text: with title, conditions, ending and warnings it stays below 12 lines."""


MAPPINGS = ("scalars", "traces", "conditions")
"""Attributes of a result that are mappings, which nobody can change."""
TOLD = ("conditions", "warnings", "ending", "converged", "machine")
"""Attributes that two equal results have in common, besides their numbers and traces."""
TIMES = {"wall_time"}
"""Numbers that say how long a computation took, and are another each time."""


@lru_cache(maxsize=4096)
def name_of(key: str, unit: str) -> str:
    """Return the name of a quantity in Python: without its SI unit, or with another one.

    Parameters
    ----------
    key : str
        Name in JSON and archives, e.g. "brake_torque_Nm".
    unit : str
        Unit of the quantity, e.g. "N m".

    Returns
    -------
    str
        Name.

    Examples
    --------
    >>> name_of("brake_torque_Nm", "N m"), name_of("speed_rpm", "r/min"), name_of("crank_angle", "deg")
    ('brake_torque', 'speed_rpm', 'crank_angle_deg')
    """
    short = without_unit(key)
    if short != key:
        return short
    suffix = UNIT_SUFFIXES.get(unit, "")
    return key if key.endswith(suffix) else f"{key}{suffix}"


def without_unit(key: str) -> str:
    """Return a name without the SI unit behind it.

    Parameters
    ----------
    key : str
        Name in JSON and archives.

    Returns
    -------
    str
        Name; as it was where no SI unit stands behind it.

    Examples
    --------
    >>> without_unit("brake_torque_Nm"), without_unit("speed_rpm")
    ('brake_torque', 'speed_rpm')
    """
    for suffix in SI_SUFFIXES:
        if key.endswith(suffix):
            return key.removesuffix(suffix)
    return key


def _not_there(name: str, known: Iterable[str]) -> str:
    """Say that there is no such name, with the nearest ones, or with all where none is near.

    >>> _not_there("lif", ["lift", "velocity"])
    'no lif; did you mean lift?'
    """
    known = list(known)
    with_unit = [other for other in known if other.startswith(f"{name}_")]
    near = with_unit or difflib.get_close_matches(name, known, n=2)
    return f"no {name}; " + (f"did you mean {' or '.join(near)}?" if near else f"there are {', '.join(known)}")


class _Named(dict[str, Any]):
    """Dictionary that says which name is near to one that it does not have."""

    def __missing__(self, name: str) -> Any:
        raise KeyError(_not_there(str(name), self))


@dataclass(frozen=True)
class Scalar:
    """One number of a result.

    Attributes
    ----------
    value : float, int, bool or str
        NaN: undefined.
    unit : str
        "1" without any.
    long_name : str
        What it is, in one line.
    """

    value: float
    unit: str = "1"
    long_name: str = ""

    def __str__(self) -> str:
        return " ".join(filter(None, (shown(self.value), "" if self.unit == "1" else self.unit)))


@dataclass(frozen=True, eq=False, repr=False)
class Trace:
    """Numbers along one or more axes; NumPy and matplotlib take it for an array.

    Attributes
    ----------
    dims : tuple of str
        Names of the axes. A trace of one axis with its own name holds the values along it.
    values : ndarray
        Numbers along the axes; read only.
    unit : str
        "1" without any.
    long_name : str
        What it is, in one line.
    """

    dims: tuple[str, ...]
    values: np.ndarray
    unit: str = "1"
    long_name: str = ""

    def __post_init__(self) -> None:
        values = np.array(self.values)
        values.flags.writeable = False
        object.__setattr__(self, "values", values)
        if values.ndim != len(self.dims):
            raise ValueError(f"values of {values.ndim} axes, but the names of {len(self.dims)}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.dims, self.values, self.unit, self.long_name)  # made anew, so that it stays read only

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self.values, dtype=dtype, copy=copy)

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, place: Any) -> Any:
        return self.values[place]

    def __repr__(self) -> str:
        shape = " x ".join(f"{size} {name}" for size, name in zip(self.values.shape, self.dims, strict=True))
        return f"<Trace [{'-' if self.unit == '1' else self.unit}] over {shape}{self._ends()}>"

    def _ends(self) -> str:
        """Least and largest number, behind a comma; nothing where there is none."""
        if self.values.dtype.kind not in "fi" or not np.isfinite(self.values).any():
            return ""
        return f", {shown(np.nanmin(self.values))} to {shown(np.nanmax(self.values))}"

    def _repr_html_(self) -> str:
        escape, size = html.escape, " x ".join(map(str, self.values.shape))
        unit = "" if self.unit == "1" else f" [{escape(self.unit)}]"
        over = f"{escape(' x '.join(self.dims))}: {size}{escape(self._ends())}"
        caption = f"<b>{escape(self.long_name)}</b>{unit} over {over}"
        return f"<div>{caption}</div>{_sparkline(self.values)}"


def _sparkline(values: np.ndarray) -> str:
    """Small picture of numbers along one axis as inline SVG; "" where there is nothing to draw."""
    if values.ndim != 1 or values.dtype.kind not in "fi" or len(values) < 2 or not np.isfinite(values).any():
        return ""
    drawn = values[np.linspace(0, len(values) - 1, min(len(values), SPARKS)).astype(int)].astype(float)
    low, high = np.nanmin(drawn[np.isfinite(drawn)]), np.nanmax(drawn[np.isfinite(drawn)])
    y = 38.0 - 36.0 * (drawn - low) / ((high - low) or 1.0)
    x = np.linspace(1.0, 239.0, len(drawn))
    points = " ".join(f"{a:.0f},{b:.1f}" for a, b in zip(x, y, strict=True) if np.isfinite(b))
    return (
        '<svg width="240" height="40" role="img" aria-hidden="true">'
        f'<polyline points="{points}" fill="none" stroke="currentColor"/></svg>'
    )


def shown(value: Any) -> str:
    """Return a value in words and digits as a reader wants it.

    Parameters
    ----------
    value : float, int, bool or str
        Value; NaN is none.

    Returns
    -------
    str
        Five digits of a float, "yes" or "no" for a flag, "-" where there is none.

    Examples
    --------
    >>> shown(2.0 / 3.0), shown(True), shown(float("nan"))
    ('0.66667', 'yes', '-')
    """
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, str | int | np.integer):
        return str(value)
    return "-" if np.isnan(value) else f"{value:.5g}"


def scalars_of(values: Mapping[str, Any], declared: Mapping[str, tuple[str, str]]) -> dict[str, Scalar]:
    """Return scalars by name, from values and declarations by the keys of JSON and archives.

    Parameters
    ----------
    values : mapping of str to float, int, bool or str
        Values by key.
    declared : mapping of str to pair of str
        Unit and long name by key; all keys of `values` among them.

    Returns
    -------
    dict of str to Scalar
        Numbers with their units, by name, see `name_of`.

    Raises
    ------
    ValueError
        Two keys make one name.

    Examples
    --------
    >>> scalars_of({"end_pressure_Pa": 4.1e5}, {"end_pressure_Pa": ("Pa abs", "pressure at the end")})
    {'end_pressure': Scalar(value=410000.0, unit='Pa abs', long_name='pressure at the end')}
    """
    scalars: dict[str, Scalar] = {}
    for key, value in values.items():
        unit, long_name = declared[key]
        name = name_of(key, unit)
        if name in scalars:
            raise ValueError(f"{key}: there is a {name} already")
        scalars[name] = Scalar(value.item() if isinstance(value, np.generic) else value, unit, long_name)
    return scalars


@dataclass(frozen=True, eq=False, repr=False)
class Result(Mapping[str, Any]):
    """Base of all results: ``result["brake_torque"]`` is a number, ``result.traces["lift"]`` an array with its unit.

    Attributes
    ----------
    scalars : mapping of str to Scalar
        In their order for readers.
    traces : mapping of str to Trace
        The coordinates among them.
    conditions : mapping of str to str
        What was computed, e.g. ``{"speed": "1000 r/min"}``.
    warnings : tuple of str
        Warnings of the computation, a text each.
    ending : str
        How the computation ended, in words; "" where there is nothing to tell.
    converged : bool or None
        None where nothing has to converge.
    machine : str
        TOML text of the machine; "" without one. A study may give the function that writes it.
    """

    title: ClassVar[str] = "result"
    """What it is the result of, in a few words."""
    headline: ClassVar[tuple[str, ...]] = ()
    """Names of the numbers that a short text shows; the first ones if empty."""

    scalars: Mapping[str, Scalar]
    traces: Mapping[str, Trace] = field(default_factory=dict)
    conditions: Mapping[str, str] = field(default_factory=dict)
    warnings: Sequence[str] = ()
    ending: str = ""
    converged: bool | None = None
    machine: LateText = LateText()  # noqa: RUF009 (a descriptor)

    def __post_init__(self) -> None:
        for name in MAPPINGS:
            object.__setattr__(self, name, MappingProxyType(_Named(getattr(self, name))))
        object.__setattr__(self, "warnings", tuple(self.warnings))

    def __getstate__(self) -> dict[str, Any]:
        plain = {name: dict(getattr(self, name)) for name in MAPPINGS}  # no proxy can be pickled or copied
        return vars(self) | plain | {"machine": self.machine}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state | {name: MappingProxyType(_Named(state[name])) for name in MAPPINGS})

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Result):
            return super().__eq__(other)
        told, others = (
            (type(result), *(getattr(result, name) for name in TOLD), set(result.scalars) - TIMES, set(result.traces))
            for result in (self, other)
        )
        return told == others and all(
            _are_same(item, theirs[name])
            for mine, theirs in ((self.scalars, other.scalars), (self.traces, other.traces))
            for name, item in mine.items()
            if name not in TIMES
        )

    def __getitem__(self, name: str) -> Any:
        scalar = self.scalars.get(name) or self.scalars.get(without_unit(name))
        if scalar is None:
            raise KeyError(self._no_such(name))
        return scalar.value

    def __iter__(self) -> Iterator[str]:
        return iter(self.scalars)

    def __len__(self) -> int:
        return len(self.scalars)

    def __bool__(self) -> bool:
        return True

    def _no_such(self, name: str) -> str:
        if name in self.traces:
            return f"{name} is a trace: write .traces[{name!r}]"
        return _not_there(name, self.scalars)

    def _headline(self) -> list[tuple[str, Scalar]]:
        names = self.headline or tuple(self.scalars)
        return [(name, self.scalars[name]) for name in names if name in self.scalars][:MAX_HEADLINES]

    def _notes(self) -> list[str]:
        notes = [self.ending] if self.ending else []
        if self.warnings:
            first = self.warnings[0] if len(self.warnings[0]) <= 90 else f"{self.warnings[0][:89]}…"
            more = f" (and {len(self.warnings) - 1} more in .warnings)" if len(self.warnings) > 1 else ""
            notes.append(f"warning: {first}{more}")
        return notes

    def _told_conditions(self) -> str:
        return ", ".join(f"{name} {text}" for name, text in self.conditions.items())

    def __repr__(self) -> str:
        conditions = self._told_conditions()
        lines = [f"{type(self).__name__}: {self.title}" + f" ({conditions})" * bool(conditions)]
        shown_here = self._headline()
        width = max((len(name) for name, _ in shown_here), default=0)
        lines += [f"  {name:{width}}  {scalar}" for name, scalar in shown_here]
        lines += [f"  {note}" for note in self._notes()]
        if rest := len(self.scalars) - len(shown_here):
            lines.append(f"  {rest} more numbers" + f", {len(self.traces)} traces" * bool(self.traces))
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        escape = html.escape
        conditions = self._told_conditions()
        caption = escape(f"{self.title}" + f" ({conditions})" * bool(conditions))
        rows = [
            f'<tr title="{escape(scalar.long_name)}"><td>{escape(name)}</td>'
            f'<td style="text-align:right">{escape(shown(scalar.value))}</td>'
            f"<td>{escape('' if scalar.unit == '1' else scalar.unit)}</td></tr>"
            for name, scalar in self._headline()
        ]
        notes = "".join(f"<div>{escape(note)}</div>" for note in self._notes())
        return f"<table><caption>{caption}</caption><tbody>{''.join(rows)}</tbody></table>{notes}"

    def to_xarray(self) -> "xarray.Dataset":
        """Return all numbers and traces, each with the attributes ``units`` and ``long_name``.

        Returns
        -------
        xarray.Dataset
            Conditions, warnings and the machine's text are attributes.

        Raises
        ------
        ImportError
            xarray is not installed.

        Examples
        --------
        >>> class LeakTest(Result):
        ...     title = "leak test"
        >>> area = Scalar(0.3, "mm^2", "area of the leak")
        >>> traces = {"time": Trace(("time",), [0.0, 1.0], "s"), "pressure": Trace(("time",), [5e5, 4e5], "Pa abs")}
        >>> result = LeakTest({"leak_area_mm2": area}, traces)
        >>> dataset = result.to_xarray()
        >>> dataset["pressure"].attrs["units"], float(dataset["leak_area_mm2"])
        ('Pa', 0.3)
        """
        xarray = needed("xarray")
        coordinates: dict[str, Any] = {}
        variables: dict[str, Any] = {}
        for name, trace in self.traces.items():
            kind = coordinates if trace.dims == (name,) else variables
            kind[name] = (trace.dims, trace.values, attributes_of(trace))
        for name, scalar in self.scalars.items():
            variables[name] = ((), scalar.value, attributes_of(scalar))
        return xarray.Dataset(variables, coordinates, self._attributes())

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the traces as a table over their coordinate; without traces, the numbers as a table of one row.

        Returns
        -------
        pandas.DataFrame
            ``attrs["units"]`` and ``attrs["long_names"]`` are mappings by column; ``attrs["scalars"]`` holds the
            numbers.

        Raises
        ------
        ImportError
            pandas is not installed.

        Examples
        --------
        >>> class LeakTest(Result):
        ...     title = "leak test"
        >>> area = Scalar(0.3, "mm^2", "area of the leak")
        >>> traces = {"time": Trace(("time",), [0.0, 1.0], "s"), "pressure": Trace(("time",), [5e5, 4e5], "Pa abs")}
        >>> result = LeakTest({"leak_area_mm2": area}, traces)
        >>> table = result.to_pandas()
        >>> table["pressure"].tolist(), table.attrs["units"]["pressure"]
        ([500000.0, 400000.0], 'Pa abs')
        """
        pandas = needed("pandas")
        axes = [name for name, trace in self.traces.items() if trace.dims == (name,)]
        shared = {name: trace for name, trace in self.traces.items() if trace.dims == tuple(axes[:1])}
        held: Mapping[str, Scalar | Trace]
        if shared:
            held = shared
            frame = pandas.DataFrame({name: trace.values for name, trace in shared.items()}).set_index(axes[0])
        else:
            held = self.scalars
            frame = pandas.DataFrame([{name: scalar.value for name, scalar in self.scalars.items()}])
        frame.attrs = self._attributes() | {
            "units": {name: item.unit for name, item in held.items()},
            "long_names": {name: item.long_name for name, item in held.items()},
            "scalars": dict(self),
        }
        return frame

    def _attributes(self) -> dict[str, Any]:
        told = {"title": self.title, **self.conditions, "warnings": "\n".join(self.warnings)}
        return told | ({"machine": self.machine} if self.machine else {})


def _are_same(one: Scalar | Trace, other: Scalar | Trace) -> bool:
    """Whether two numbers or traces are the same; NaN is NaN."""
    mine, theirs = (item.value if isinstance(item, Scalar) else item.values for item in (one, other))
    are_floats = all(np.asarray(value).dtype.kind == "f" for value in (mine, theirs))
    told = [(getattr(item, "dims", ()), item.unit, item.long_name) for item in (one, other)]
    return told[0] == told[1] and np.array_equal(mine, theirs, equal_nan=are_floats)


def attributes_of(item: Scalar | Trace) -> dict[str, str]:
    """Return the attributes of a variable of an xarray Dataset, by the CF conventions as in archives.

    Names of the attributes and the spelling of units are those of the CF conventions [1]_; ``reference`` is ours.

    Parameters
    ----------
    item : Scalar or Trace
        Number or trace with its unit.

    Returns
    -------
    dict of str to str
        ``units``, ``long_name`` and, for a pressure, ``reference``.

    References
    ----------
    .. [1] "CF Metadata Conventions", https://cfconventions.org.

    Examples
    --------
    >>> attributes_of(Scalar(4.1e5, "Pa abs", "pressure at the end"))
    {'units': 'Pa', 'long_name': 'pressure at the end', 'reference': 'absolute'}
    """
    from apesim.archive.conventions import cf_unit

    unit, reference = cf_unit(item.unit)
    return {"units": unit, "long_name": item.long_name} | ({"reference": reference} if reference else {})


def needed(package: str) -> Any:
    """Return a package that only some users need.

    Parameters
    ----------
    package : str
        Name of the package, and of the extra of apesim that installs it.

    Returns
    -------
    module
        Package, imported.

    Raises
    ------
    ImportError
        It is not installed; the message says how to install it.

    Examples
    --------
    >>> needed("no_such_package")
    Traceback (most recent call last):
    ...
    ImportError: this needs no_such_package: python -m pip install "apesim[no_such_package]"
    """
    import importlib

    try:
        return importlib.import_module(package)
    except ImportError:
        raise ImportError(f'this needs {package}: python -m pip install "apesim[{package}]"') from None


class NotConverged(Exception):
    """A computation that ended without the state it was to reach.

    Parameters
    ----------
    what : str
        The point that was computed.
    wrong : str
        How it ended.
    right : str
        What may help.
    result : Result or None
        What was found nevertheless; None: nothing.

    Attributes
    ----------
    result : Result or None
        What was found nevertheless; None: nothing.
    remedy : str
        What may help.
    """

    def __init__(self, what: str, wrong: str, right: str, result: Result | None) -> None:
        super().__init__(what, wrong, right, result)
        self.result: Any = result
        self.remedy = right
        self._line = f"{what}: {wrong}; {right}"

    def __str__(self) -> str:
        return self._line
