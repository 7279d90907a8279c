"""Machines that differ in some keys: a full grid of their values."""

from itertools import product
from math import prod
from typing import NamedTuple

from apesim.engine.machine import Machine
from apesim.quantities import Choice, Culprit, Curve, InputError, Pressure, Quantity, parse_range, quoted, unit
from apesim.quantities.declarations import Declaration
from apesim.quantities.settings import misassigned, schema

VARY = "--vary"
INTAKE_KEY, AMBIENT_KEY = "engine.intake", "ambient.pressure"
MAX_COMBINATIONS = 100_000


class Axis(NamedTuple):
    """A key of the machine, and the values that it takes."""

    key: str
    """With dots, e.g. "supply.pressure"."""
    declaration: Declaration
    texts: tuple
    """Texts that a machine file would have; of a curve, the path."""
    values: tuple
    """Values in the machine: in SI, a choice as its index; of a curve, the path."""

    @property
    def name(self):
        """Name in archives, where no dot may stand."""
        return self.key.replace(".", "_")


class Variation(NamedTuple):
    """Machines for all combinations of the values of some keys."""

    axes: tuple
    """Axes, each an `Axis`."""
    machines: tuple
    """Machines, each a `Machine`; the last axis runs fastest."""


def vary(texts, path=None, settings=()):
    """Read which keys of a machine take which values; each combination is as if it had been given by `--set`.

    Parameters
    ----------
    texts : sequence of str
        ``KEY=RANGE``, e.g. "supply.pressure=0.6:1.4:0.2 MPa gauge", "air.model=ideal,cantera".
    path : path, optional
        Machine file.
    settings : sequence of str
        ``KEY=VALUE``, for all the machines.

    Returns
    -------
    Variation

    Raises
    ------
    InputError
        With a culprit for each text, value, or kind of fault that combinations have.
    """
    base = Machine.load(path, settings)
    declarations = {leaf.key: leaf.declaration for leaf in schema(type(base))}
    given, axes, culprits = set(), [], []
    for text in texts:
        key, equals, values = (part.strip() for part in text.partition("="))
        form = 'write KEY=RANGE, e.g. supply.pressure="0.6:1.4:0.2 MPa gauge"'
        if not equals:
            culprits.append(Culprit(VARY, "", f"{quoted(text)} varies nothing", form))
        elif key not in declarations:
            culprits.append(misassigned(type(base), key, VARY))
        elif key == INTAKE_KEY:
            culprits.append(Culprit(VARY, key, "has an option of its own", "write --intake epv,cam,ideal"))
        elif key in given:
            culprits.append(Culprit(VARY, key, "is given twice", "give all its values at once"))
        else:
            given.add(key)
            try:
                above = None if key == AMBIENT_KEY else base.ambient.pressure
                axes.append(_axis(key, declarations[key], values, above))
            except InputError as error:
                culprits += error.culprits
    if AMBIENT_KEY in given:
        gauges = [text.partition("=")[0].strip() for text in texts if "gauge" in text]
        right = f"write it abs, as {AMBIENT_KEY} varies, above which gauge pressures stand"
        culprits += [Culprit(VARY, key, "is gauge and so has no one value", right) for key in gauges]
    number = prod(len(axis.texts) for axis in axes)
    if number > MAX_COMBINATIONS:
        culprits.append(Culprit(VARY, "", f"makes {number} machines", f"at most {MAX_COMBINATIONS}: larger steps"))
    if culprits:
        raise InputError(culprits)
    return Variation(tuple(axes), _machines(axes, path, settings))


def _axis(key, declaration, text, ambient_pressure):
    """The values of a key; raises `InputError`."""
    items = text if isinstance(declaration, Quantity) else [item.strip() for item in text.split(",")]
    values = parse_range(items, declaration, ambient_pressure, where=key, file=VARY)
    if isinstance(declaration, Curve):
        texts = values = items
    else:
        texts = [declaration.render(value, ambient_pressure) for value in values]
    twice = [text for text in dict.fromkeys(texts) if texts.count(text) > 1]
    if twice:
        raise InputError([Culprit(VARY, key, f"{quoted(text)} is given twice", "give it once") for text in twice])
    return Axis(key, declaration, tuple(texts), tuple(values))


def _machines(axes, path, settings):
    """A machine for each combination; raises `InputError` with one culprit for each kind of fault."""
    machines, faults = [], {}
    for texts in product(*(axis.texts for axis in axes)):
        assigned = [f"{axis.key}={text}" for axis, text in zip(axes, texts, strict=True)]
        try:
            machines.append(Machine.load(path, [*settings, *assigned]))
        except InputError as error:
            for culprit in error.culprits:
                faults.setdefault((culprit.key, culprit.right), []).append((culprit.wrong, ", ".join(assigned)))
    if faults:
        raise InputError([_fault(key, right, found) for (key, right), found in faults.items()])
    return tuple(machines)


def _fault(key, right, found):
    """The culprit of what is wrong with some combinations."""
    (wrong, first), *others = found
    more = f" and {len(others)} more" if others else ""
    return Culprit(VARY, key, f"{wrong} (with {first}{more})", right)


def stored(axis):
    """Values of an axis as archives hold them, and their unit: SI, but angles in degrees.

    Parameters
    ----------
    axis : Axis

    Returns
    -------
    values : list of float, int or str
    unit : str
    """
    if isinstance(axis.declaration, Choice | Curve):
        return list(axis.values), "1"
    if isinstance(axis.declaration, Pressure):
        return list(axis.values), "Pa abs"
    if unit(axis.declaration.unit) == unit("deg"):
        return [float(text.split()[0]) for text in axis.texts], "deg"
    name = unit(axis.declaration.unit).si_text
    return list(axis.values), "1" if name == "-" else name
