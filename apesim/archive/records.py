"""What an archive holds in memory: variables with named axes, units and one leading axis, the runs."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass, field

import numpy as np

from apesim.late_text import LateText

FORMAT = "apesim archive"
FORMAT_VERSION = 3
FIRST_WITH_DIGESTS = 2
"""Format version since which an archive carries SHA-256 digests."""
FLAG_ATTRIBUTES = ("coordinate", "finite")
"""Attributes that are 1 where they are there."""
CODE_ATTRIBUTES = ("flag_values",)
"""Attributes that list codes."""
TEXT_ATTRIBUTES = ("axes", "coordinates", "dimensions", "flag_meanings", "long_name", "meanings", "reference", "units")
ATTRIBUTES = tuple(sorted(FLAG_ATTRIBUTES + CODE_ATTRIBUTES + TEXT_ATTRIBUTES))
"""Attributes by which a dataset says what it is; ``dimensions`` stands for ``axes`` before format version 3."""
ROOT_ATTRIBUTES = ("Conventions", "format", "format_version", "history", "source", "title")
"""Attributes by which a file says what it is; before format version 3 the format and its version alone."""
KIND = "kind"
"""Entry of the provenance, and attribute of the root, that says which study's results an archive holds.

The root digest covers it with the provenance alone, so that programs from before there were kinds read the file.
"""
ATTRIBUTE_BYTES = 2**15

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.]{0,99}")
_MEANING = re.compile(r"(-?\d{1,3}) ([^,]+)")


@dataclass(frozen=True, eq=False)
class Variable:
    """One quantity of an archive.

    Attributes
    ----------
    dims : tuple of str
        Names of the axes. Results begin with "run"; an axis has its own name as its only one.
    values : ndarray
        float64 (NaN is a missing value), int64, int8 (flags and codes) or text.
    unit : str
        Such as "Pa abs"; "1" for numbers without unit, codes and text.
    description : str
        One line.
    meanings : str
        What the codes of an int8 variable mean: "0 epv, 1 cam".
    finite : bool
        Neither NaN nor infinity may occur. Axes are always so.
    coordinate : bool
        It says where in a grid the runs lie, such as a speed or a pressure, and is no result.
    """

    dims: tuple[str, ...]
    values: np.ndarray
    unit: str
    description: str
    meanings: str = ""
    finite: bool = False
    coordinate: bool = False

    @property
    def kind(self) -> str:
        """Type of the values: "float64", "int64", "int8" or "text"."""
        return "text" if self.values.dtype.kind == "U" else str(self.values.dtype)


@dataclass(frozen=True, eq=False)
class Archive:
    """Results of runs of one machine.

    Attributes
    ----------
    machine : str
        TOML text of the whole machine; a study may give the function that writes it.
    provenance : dict of str to str
        Where the results come from; `write` adds what it knows itself.
    variables : dict of str to Variable
        Axes and results by name; "run" holds the run numbers (int64, increasing).
    """

    machine: LateText = LateText()  # noqa: RUF009 (a descriptor)
    provenance: dict[str, str] = field(default_factory=dict)
    variables: dict[str, Variable] = field(default_factory=dict)

    @property
    def runs(self) -> np.ndarray:
        """Run numbers, shape (runs,), int64."""
        return self.variables["run"].values


def sha256(text: str) -> str:
    """Return the hexadecimal hash of a text in UTF-8, as it is stored under ``machine_sha256``."""
    return hashlib.sha256(text.encode()).hexdigest()


def validate(archive: Archive) -> None:
    """Check that an archive can be written.

    Raises ValueError where a text or a variable cannot be stored, an axis has no variable, or the lengths along an axis
    differ; the message names the variable, what is wrong and what would be right.
    """
    _storable("machine", archive.machine)
    for key, value in archive.provenance.items():
        if not isinstance(key, str) or not isinstance(value, str):
            raise ValueError(f"provenance {key!r}: {value!r} is not text; convert it with str()")
        _storable("provenance", key + value)
    if "run" not in archive.variables:
        raise ValueError("no variable 'run'; give the run numbers, dims ('run',), int64")
    for name, variable in archive.variables.items():
        check_variable(name, variable)
        for axis, length in zip(variable.dims, variable.values.shape, strict=True):
            coordinate = archive.variables.get(axis)
            if coordinate is None or coordinate.dims != (axis,):
                raise ValueError(f"{name}: no variable for its axis {axis!r}; add one with dims ({axis!r},)")
            if len(coordinate.values) != length:
                raise ValueError(f"{name}: {length} values along {axis!r} of {len(coordinate.values)}")


def check_variable(name: str, variable: Variable) -> None:
    """Check one variable by itself: name, form, units, codes, finite values.

    Raises ValueError where it cannot be stored; the message names the variable, what is wrong and what would be right.

    >>> import numpy as np
    >>> check_variable("speed", Variable(("run",), np.array([600.0]), "", "speed of the crank"))
    Traceback (most recent call last):
    ...
    ValueError: speed: no unit; a number without one has the unit '1'
    """
    values, dims = variable.values, variable.dims

    # Names come first: every message that follows begins with one.
    for text in (name, *dims):
        if not isinstance(text, str) or not _NAME.fullmatch(text) or text == "about":
            raise ValueError(f"{text!r} is no name for a variable; use letters, digits, '_' and '.'")

    # The form: an array of a type that a file can hold, over axes that fit. The checks of values rely on it.
    if not isinstance(values, np.ndarray) or (
        values.dtype not in (np.float64, np.int64, np.int8) and (values.dtype.kind != "U")
    ):
        kind = getattr(values, "dtype", type(values).__name__)
        raise ValueError(f"{name}: values of type {kind}; give an array of float64, int64, int8 or text")
    if values.ndim != len(dims) or len(set(dims)) != len(dims):
        raise ValueError(f"{name}: shape {values.shape} does not fit the axes {dims}")
    axis = dims == (name,)
    if not axis and (not dims or dims[0] != "run" or name in dims):
        raise ValueError(f"{name}: axes {dims}; results begin with 'run', an axis has the dims ({name!r},)")

    # What says what it is becomes an attribute of the dataset, whose length is limited.
    for label, text in (
        ("unit", variable.unit),
        ("description", variable.description),
        ("meanings", variable.meanings),
    ):
        if not isinstance(text, str) or not text.isprintable() or len(text.encode()) > ATTRIBUTE_BYTES:
            raise ValueError(f"{name}: {label} {text!r:.80} is not one printable line")
    if not variable.unit.strip():
        raise ValueError(f"{name}: no unit; a number without one has the unit '1'")

    # The values. Axes have to be finite whether they are declared so or not.
    if (axis or variable.finite) and values.dtype.kind == "f" and not np.isfinite(values).all():
        raise ValueError(f"{name}: NaN or infinity, but its values must be finite")
    if name == "run" and (values.dtype != np.int64 or (values < 0).any() or (np.diff(values) <= 0).any()):
        raise ValueError("run: run numbers must be int64, not negative and increasing")
    if values.dtype.kind == "U":
        _storable(name, "".join(values.ravel().tolist()))

    # Codes: without a word for each of them a reader could not tell what it means.
    if variable.meanings:
        codes = codes_of(variable.meanings)
        if values.dtype != np.int8 or not codes:
            raise ValueError(f"{name}: meanings {variable.meanings!r}; write '0 epv, 1 cam', for int8 only")
        unknown = np.setdiff1d(values, list(codes))
        if unknown.size:
            raise ValueError(f"{name}: code {unknown[0]} has no meaning in {variable.meanings!r}")


def codes_of(meanings: str) -> dict[int, str]:
    """Return the words of meanings such as "0 epv, 1 cam", by code from -128 to 127; none where the text is wrong."""
    entries = [_MEANING.fullmatch(entry.strip()) for entry in meanings.split(",")]
    codes = {int(entry[1]): entry[2] for entry in entries if entry}
    return codes if len(codes) == len(entries) and all(-128 <= code < 128 for code in codes) else {}


def _storable(name: str, text: str) -> None:
    if not isinstance(text, str) or "\0" in text:
        raise ValueError(f"{name}: not a text without NUL characters")
    try:
        text.encode()
    except UnicodeEncodeError:
        raise ValueError(f"{name}: a text that has no UTF-8 form") from None
