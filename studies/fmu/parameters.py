"""Parameters of an FMU: keys of the machine that an importer may change, found by trial, and those fixed at export."""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from math import isfinite, isnan
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.quantities import Quantity
from apesim.quantities.trees import leaves_of, overruled, with_value
from apesim.studies.fmu.flat import flatten

SHARES = 0.01, 0.03
"""Shares by which a key is changed to see what follows; two, as one does not show a curve."""
EXACT = 1e-9
"""Relative error up to which a number follows a key as predicted; far above rounding, far below any curve."""


class Effect(NamedTuple):
    """How a number of the machine follows a key: ``number = number at export + factor (value - value at export)``."""

    number: int
    """Place of the number among those of the machine."""
    factor: float
    """Factor of the change."""
    is_value: bool
    """Whether the number is the value of the key itself."""


class Parameter(NamedTuple):
    """Key of the machine."""

    key: str
    """Key of the machine file."""
    declaration: Quantity
    """Its unit, range and source."""
    value: float
    """Its value at export, in SI."""
    effects: tuple[Effect, ...] = ()
    """Numbers that follow it; none: it is fixed at export."""


def find_parameters(
    machine: Machine, numbers_of: Callable[[Machine], Any], given: Sequence[str] = (), held: Sequence[str] = ()
) -> tuple[list[Parameter], list[Parameter]]:
    """Find the keys that an importer may change, and those that the machine's numbers follow in another way.

    A key may be changed where every number that follows it does so along a line, alone and with all other such keys
    changed, too: then the FMU computes from them what the export would have computed. The keys `given` by inputs are
    left out; those that begin with one of `held` are fixed.
    """
    lines: list[Parameter] = []
    fixed: list[Parameter] = []
    base = flatten(numbers_of(machine))
    for key, declaration, value in _numbers_in(machine, given):
        moved = [flatten(numbers_of(with_value(machine, key, _changed(declaration, value, s)))) for s in SHARES]
        if all(np.array_equal(base.view(np.int64), row.view(np.int64)) for row in moved if len(row) == len(base)):
            continue
        changes = [_changed(declaration, value, share) - value for share in SHARES]
        effects = () if key.startswith(tuple(held)) else _effects(base, moved, value, changes)
        (lines if effects else fixed).append(Parameter(key, declaration, value, effects))

    # Those that act on a number together, other than by their sum, cannot all be changed.
    free: list[Parameter] = []
    for parameter in lines:
        if _is_sum(machine, numbers_of, base, [*free, parameter]):
            free.append(parameter)
        else:
            fixed.append(parameter._replace(effects=()))
    return free, fixed


def _numbers_in(machine: Machine, given: Sequence[str]) -> Iterator[tuple[str, Quantity, float]]:
    """Keys that have a number which is given, but effects that are off."""
    unused = [f"{key}." for key, _ in overruled(machine)]
    for key, leaf in leaves_of(type(machine)).items():
        declaration = leaf.declaration
        is_used = key not in given and not f"{key}.".startswith(tuple(unused))
        if isinstance(declaration, Quantity) and not declaration.whole and is_used:
            value = attrgetter(key)(machine)
            if isfinite(value) and not _is_of_effect_that_is_off(machine, key):
                yield key, declaration, float(value)


def _is_of_effect_that_is_off(machine: Machine, key: str) -> bool:
    """Whether a key is one of an effect that has no other values than those by which it is off."""
    section, _, rest = key.partition(".")
    name = rest.partition(".")[0]
    leaves = leaves_of(type(machine))
    return section == "effects" and all(
        leaf.default == attrgetter(other)(machine) or leaf.default != leaf.default
        for other, leaf in leaves.items()
        if other.startswith(f"effects.{name}.") and isinstance(leaf.declaration, Quantity)
    )


def _changed(declaration: Quantity, value: float, share: float) -> float:
    """A value within the range, changed by a share of itself, or of the range's end where it is 0."""
    low, high = declaration.ends
    by = share * (value or (high if isfinite(high) else 1.0))
    return value + by if low <= value + by <= high else value - by


def _effects(
    base: np.ndarray, moved: Sequence[np.ndarray], value: float, changes: Sequence[float]
) -> tuple[Effect, ...]:
    """How the numbers follow a key; none where one of them does not follow along a line."""
    if any(len(row) != len(base) for row in moved):
        return ()
    bits = base.view(np.int64)
    effects = []
    for i in np.flatnonzero(np.any([row.view(np.int64) != bits for row in moved], axis=0)):
        if base[i] == value and all(row[i] == value + change for row, change in zip(moved, changes, strict=True)):
            effects.append(Effect(int(i), 1.0, True))
            continue
        first, second = ((row[i] - base[i]) / change for row, change in zip(moved, changes, strict=True))
        if isnan(first) or not abs(second - first) <= EXACT * abs(second) + _rounding(base[i], changes[0]):
            return ()
        effects.append(Effect(int(i), float(second), False))
    return tuple(effects)


class Order(NamedTuple):
    """Two numbers of an array of the machine, of which the second has to be above the first."""

    low: int
    high: int
    keys: tuple[str, ...]
    """Keys that they follow."""


def find_orders(example: Any, parameters: Sequence[Parameter]) -> list[Order]:
    """Find the numbers that have to stay in order: the first columns of tables, where they follow parameters."""
    followed: dict[int, list[str]] = {effect.number: [] for each in parameters for effect in each.effects}
    for each in parameters:
        for effect in each.effects:
            followed[effect.number].append(each.key)
    orders = []
    for first, array in _arrays_in(example, 0):
        if array.ndim == 2 and array.shape[1] == 2:
            rows = range(first, first + array.size, 2)
            for low, high in pairwise(rows):
                keys = {*followed.get(low, ()), *followed.get(high, ())}
                if keys:
                    orders.append(Order(low, high, tuple(sorted(keys))))
    return orders


def _arrays_in(value: Any, first: int) -> Iterator[tuple[int, np.ndarray]]:
    """Arrays of a tuple, each with the place of its first number in the row of all."""
    for member in value:
        if isinstance(member, tuple):
            yield from _arrays_in(member, first)
        elif isinstance(member, np.ndarray):
            yield first, member
        first += len(flatten((member,)))


def _rounding(number: float, change: float) -> float:
    """Error of a slope by the rounding of a number."""
    return 4.0 * float(np.finfo(float).eps) * abs(number / change)


def _is_sum(
    machine: Machine, numbers_of: Callable[[Machine], Any], base: np.ndarray, parameters: list[Parameter]
) -> bool:
    """Whether all numbers follow several keys, each changed, by the sum of what they follow each."""
    together, predicted = machine, base.copy()
    for key, declaration, value, effects in parameters:
        changed = _changed(declaration, value, SHARES[1])
        together = with_value(together, key, changed)
        for number, factor, is_value in effects:
            predicted[number] = changed if is_value else predicted[number] + factor * (changed - value)
    actual = flatten(numbers_of(together))
    if len(actual) != len(base):
        return False
    others = actual.view(np.int64) != predicted.view(np.int64)
    actual, predicted, base = (numbers[others] for numbers in (actual, predicted, base))
    return bool(np.all(np.abs(actual - predicted) <= EXACT * np.maximum(np.abs(actual), np.abs(base))))
