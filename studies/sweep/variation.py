"""Machines that differ in some keys: a full grid of their values."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from math import prod
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.columns import column, meanings_of
from apesim.archive.grid import axes_of
from apesim.engine.machine import Machine
from apesim.quantities import (
    Arguments,
    Choice,
    Curve,
    Fault,
    InputError,
    Pressure,
    Quantity,
    QuantityList,
    quoted,
    unit,
)
from apesim.quantities.arguments import Declared, values_of
from apesim.quantities.declarations import Declaration
from apesim.quantities.settings import misassigned, schema
from apesim.quantities.trees import spellings

VARY = "--vary"
"""Option that faults of varied keys name on the command line."""
INTAKE_KEY, AMBIENT_KEY = "engine.intake", "ambient.pressure"
MAX_COMBINATIONS = 100_000
OF_MACHINE = " of the machine"
"""What follows the key in the description of a column with its values."""


def varied_keys(archive: Archive) -> dict[str, str]:
    """Give the key of the machine of each axis of an archive that is one, e.g. "supply.pressure", by its name."""
    described = {name: archive.variables[name].description for name in axes_of(archive)}
    return {name: text.removesuffix(OF_MACHINE) for name, text in described.items() if text.endswith(OF_MACHINE)}


class Axis(NamedTuple):
    """One axis of a variation: a key of the machine, and the values that it takes."""

    key: str
    """Key with dots, e.g. "supply.pressure"."""
    declaration: Declaration
    """What the machine declares of this key: kind, unit and range."""
    texts: tuple[str, ...]
    """Values as a machine file would write them; for a curve, the path of its file."""
    values: tuple[Any, ...]
    """Values in the machine: in SI, a choice as its index; for a curve, the path of its file."""

    @property
    def name(self) -> str:
        """Name of the axis in archives, where no dot may stand: "supply_pressure"."""
        return self.key.replace(".", "_")


class Variation(NamedTuple):
    """Machines for all combinations of the values of some keys."""

    axes: tuple[Axis, ...]
    """Axes, in the order in which they were given."""
    machines: tuple[Machine, ...]
    """A machine for each combination; the last axis runs fastest."""


Vary = Mapping[str, Any] | Sequence[str] | Variation
"""What a public function takes to vary keys of a machine, see `read_variation`."""


def vary(
    texts: Sequence[str],
    path: str | PathLike[str] | None = None,
    settings: Sequence[str] = (),
    *,
    has_intakes: bool = True,
) -> Variation:
    """Make the machines in which some keys take all combinations of given values, from the options of a command.

    `texts` are ``KEY=RANGE``, such as "supply.pressure=0.6:1.4:0.2 MPa gauge" or "air.model=ideal,thermally_perfect";
    each machine is as if its values had been given by ``--set``, after the ``KEY=VALUE`` of `settings`. Without `path`
    the embedded machine is varied. `has_intakes`: the command has an option for what opens the intake, so that its key
    is not varied. Raises an InputError that names every fault: invalid keys or values, a key given twice, combinations
    that make an invalid machine.

    >>> variation = vary(["supply.pressure=0.6:1.4:0.4 MPa gauge", "air.model=ideal,thermally_perfect"])
    >>> variation.axes[0].texts
    ('0.6 MPa gauge', '1 MPa gauge', '1.4 MPa gauge')
    >>> len(variation.machines)
    6
    """

    def make(assigned: dict[str, str]) -> Machine:
        return Machine.load(path, [*settings, *(f"{key}={text}" for key, text in assigned.items())])

    return _vary(Machine.load(path, settings), _pairs(texts), make, VARY, has_intakes=has_intakes)


def read_variation(
    arguments: Arguments, machine: Machine, vary: Vary | None, *, has_intakes: bool = True
) -> Variation | None:
    """Make the machines that the argument `vary` of a public function asks for; its faults are noted."""
    if vary is None or isinstance(vary, Variation):
        return vary
    try:
        return vary_machine(machine, vary, f"{arguments.where}: vary", has_intakes=has_intakes)
    except InputError as error:
        arguments.faults += error.faults
        return None


def vary_machine(
    machine: Machine, ranges: Mapping[str, Any] | Sequence[str], where: str, *, has_intakes: bool = True
) -> Variation:
    """Vary keys of a machine that was made in Python; each combination is as if made by its `with_`.

    `ranges` has values by key, with dots or underscores: a range or list in a text, or a sequence of texts and numbers
    in SI; else texts ``KEY=RANGE``. `where` names function and argument, for messages. Raises an InputError that names
    every fault: invalid keys or values, a key given twice, combinations that make an invalid machine.

    >>> variation = vary_machine(Machine(), {"engine_bore": ["80 mm", 0.09]}, "sweep()")
    >>> [machine.engine.bore for machine in variation.machines]
    [0.08, 0.09]
    """
    pairs = list(ranges.items()) if isinstance(ranges, Mapping) else _pairs(ranges)
    strange = [key for key, _ in pairs if not isinstance(key, str)]
    if strange:
        right = 'write e.g. {"supply.pressure": "0.6:1.4:0.2 MPa gauge"}'
        raise InputError([Fault(where, "", f"{quoted(key)} is no key", right) for key in strange])
    keys = [*(leaf.key for leaf in schema(type(machine))), *spellings(type(machine))]
    by_underscores = {key.replace(".", "_"): key for key in keys}
    pairs = [(by_underscores.get(key, key), values) for key, values in pairs]
    return _vary(machine, pairs, lambda assigned: machine.with_(**assigned), where, has_intakes=has_intakes)


def _pairs(texts: Sequence[str]) -> list[tuple[str, Any]]:
    """Keys and ranges of texts ``KEY=RANGE``; a text without a range has None."""
    split = [
        text.partition("=") if isinstance(text, str) else (text, "", "")
        for text in ([texts] if isinstance(texts, str) else texts)
    ]
    return [(key.strip(), values.strip()) if equals else (key, None) for key, equals, values in split]


def _vary(
    base: Machine,
    pairs: list[tuple[str, Any]],
    make: Callable[[dict[str, str]], Machine],
    where: str,
    *,
    has_intakes: bool,
) -> Variation:
    """Machines for all combinations, see `vary`; `make` makes one from texts by key."""
    declarations, others = {leaf.key: leaf.declaration for leaf in schema(type(base))}, spellings(type(base))

    # Faults of all keys are gathered, so that they are told at once.
    seen, axes, all_faults = set(), [], []
    for key, values in pairs:
        if values is None:
            right = 'write KEY=RANGE, e.g. supply.pressure="0.6:1.4:0.2 MPa gauge"'
            all_faults.append(Fault(where, "", f"{quoted(key)} varies nothing", right))
        elif key in others:
            right = others[key].key
            all_faults.append(Fault(where, key, f"is another spelling of {right}", f"vary {right}"))
        elif key not in declarations:
            all_faults.append(misassigned(type(base), key, where))
        elif declarations[key].is_table or isinstance(declarations[key], QuantityList):
            what = "table" if declarations[key].is_table else "list"
            all_faults.append(Fault(where, key, f"is a {what}, no number", "vary a number, e.g. valve.stroke"))
        elif key == INTAKE_KEY and has_intakes:
            option = "--intake epv,cam,ideal" if where == VARY else 'intake="epv, cam, ideal"'
            all_faults.append(Fault(where, key, "has an option of its own", f"write {option}"))
        elif key in seen:
            all_faults.append(Fault(where, key, "is given twice", "give all its values at once"))
        else:
            seen.add(key)

            # A gauge pressure stands above the ambient pressure, but the ambient pressure itself stands above nothing.
            try:
                above = None if key == AMBIENT_KEY else base.ambient.pressure
                axes.append(_axis(key, declarations[key], values, above, where))
            except InputError as error:
                all_faults += error.faults

    # A gauge pressure would be another absolute one in each machine; judged here, whatever the order of the keys.
    if AMBIENT_KEY in seen:
        pressures = [pair for pair in pairs if isinstance(declarations.get(pair[0]), Pressure)]
        gauges = [key for key, values in pressures if "gauge" in str(values)]
        right = f"write it abs, as {AMBIENT_KEY} varies, above which gauge pressures stand"
        all_faults += [Fault(where, key, "is gauge and so has no one value", right) for key in gauges]

    # Too many machines are refused before the first of them is made.
    number = prod(len(axis.texts) for axis in axes)
    if number > MAX_COMBINATIONS:
        all_faults.append(Fault(where, "", f"makes {number} machines", f"at most {MAX_COMBINATIONS}: larger steps"))
    if all_faults:
        raise InputError(all_faults)
    return Variation(tuple(axes), _machines(axes, make, where))


def _axis(key: str, declaration: Declared, asked: Any, ambient_pressure: float | None, where: str) -> Axis:
    """The values of a key; raises `InputError`."""
    is_list = isinstance(asked, str) and not isinstance(declaration, Quantity)
    items = [item.strip() for item in asked.split(",")] if is_list else asked
    values = values_of(items, declaration, ambient_pressure, where=key, file=where)
    if isinstance(declaration, Curve):
        texts = values = [str(item) for item in items]
    else:
        texts = [declaration.render(value, ambient_pressure) for value in values]
    twice = [text for text in dict.fromkeys(texts) if texts.count(text) > 1]
    if twice:
        raise InputError([Fault(where, key, f"{quoted(text)} is given twice", "give it once") for text in twice])
    return Axis(key, declaration, tuple(texts), tuple(values))


def _machines(axes: list[Axis], make: Callable, where: str) -> tuple[Machine, ...]:
    """A machine for each combination; raises `InputError` with a fault of each kind."""
    machines: list[Machine] = []
    faults: dict[tuple[str, str], list[tuple[str, str]]] = {}
    for texts in product(*(axis.texts for axis in axes)):
        assigned = {axis.key: text for axis, text in zip(axes, texts, strict=True)}
        try:
            machines.append(make(assigned))
        except InputError as error:
            words = ", ".join(f"{key}={text}" for key, text in assigned.items())
            for fault in error.faults:
                faults.setdefault((fault.key, fault.right), []).append((fault.wrong, words))
    if faults:
        raise InputError([_fault(key, right, cases, where) for (key, right), cases in faults.items()])
    return tuple(machines)


def _fault(key: str, right: str, cases: list[tuple[str, str]], where: str) -> Fault:
    """The fault of what is wrong with some combinations."""
    (wrong, first), *others = cases
    more = f" and {len(others)} more" if others else ""
    return Fault(where, key, f"{wrong} (with {first}{more})", right)


def stored(axis: Axis) -> tuple[list[Any], str]:
    """Convert the values of an axis to those that archives hold, and name their unit ("1" where they have none).

    Numbers are in SI, but angles in degrees; choices become indices, curves their paths.
    """
    if isinstance(axis.declaration, Choice | Curve):
        return list(axis.values), "1"
    if isinstance(axis.declaration, Pressure):
        return list(axis.values), "Pa abs"
    if unit(axis.declaration.unit) == unit("deg"):  # type: ignore[attr-defined]
        return [float(text.split()[0]) for text in axis.texts], "deg"
    name = unit(axis.declaration.unit).si_text  # type: ignore[attr-defined]
    return list(axis.values), "1" if name == "-" else name


def varied_columns(variation: Variation, combinations: Sequence[int]) -> dict[str, Variable]:
    """Make the columns of an archive with the values that the varied keys have, for runs of these combinations."""
    shape = [len(axis.values) for axis in variation.axes]
    places = np.unravel_index(np.asarray(combinations, dtype=int), shape) if shape else ()
    variables = {}
    for axis, at in zip(variation.axes, places, strict=True):
        values, unit = stored(axis)
        meanings = meanings_of(axis.declaration.options) if isinstance(axis.declaration, Choice) else ""
        kind = np.str_ if isinstance(axis.declaration, Curve) else float
        varied = column(np.array([values[place] for place in at], kind), unit, f"{axis.key}{OF_MACHINE}", meanings)
        variables[axis.name] = replace(varied, coordinate=True)
    return variables
