"""Free parameters of an identification, from their text."""

from collections.abc import Sequence
from enum import StrEnum
from fractions import Fraction
from math import inf

from apesim.engine.machine import Machine
from apesim.quantities import Fault, InputError, InvalidValue, Quantity, quoted, unit
from apesim.quantities.settings import schema
from apesim.studies.identify.simulation import Free
from apesim.valve.effects import ValveEffects


class Method(StrEnum):
    """How free parameters are found."""

    LEAST_SQUARES = "least-squares"
    """Least squares from several starts, with intervals by profile likelihood."""
    GENETIC = "ga"
    """The genetic algorithm of the EPV paper (doi 10.1631/jzus.A0820373), Table 2, without intervals."""


METHODS = LEAST_SQUARES, GENETIC = tuple(Method)
PAPER_RANGES = {"valve.viscous_friction": (100.0, 120.0)}
"""Search space of the genetic algorithm: the EPV paper (doi 10.1631/jzus.A0820373), Table 2 [N s/m]."""
BENCH = ("air", "ambient", "supply", "valve")
"""Sections of the machine that the valve's bench is made of, besides its effects."""
COMMAND_LINE = "command line", "--free"
EXAMPLE = "valve.viscous_friction"


def si_unit(declaration: Quantity) -> str:
    """Find the name of the SI unit of a quantity: the declared one if it is that.

    Behind the unit of a pressure it says whether it is absolute.
    """
    own = unit(declaration.unit)
    si = own._replace(factor=Fraction(1), offset=Fraction(0))
    names = [name for name in (declaration.unit, "Pa") if unit(name) == si]
    return f"{names[0] or '-'}{declaration.suffix}" if names else own.si_text


def free_parameters(
    machine: Machine, texts: Sequence[str], method: str = LEAST_SQUARES, where: tuple[str, str] = COMMAND_LINE
) -> list[Free]:
    """Find what ``KEY`` and ``KEY=LOW:HIGH`` set free, e.g. ``valve.viscous_friction=100 N s/m:120 N s/m``.

    Without bounds, the declared range of the key holds. `method` is "least-squares" or "ga", `where` the file and key
    that a fault names. Raises InputError with every fault.
    """
    leaves = {leaf.key: leaf for leaf in schema(type(machine), machine)}
    found: list[Free] = []
    all_faults: list[Fault] = []
    for text in texts:
        key, given, bounds = (part.strip() for part in text.partition("="))
        try:
            declaration = leaves[key].declaration if key in leaves else None
            if not isinstance(declaration, Quantity):
                raise InvalidValue(f"{quoted(key)} is no key of a quantity", "give one, e.g. valve.viscous_friction")
            if not _on_bench(key):
                right = "free a key of the valve, its effects, the supply, the ambient or the air"
                raise InvalidValue(f"{key} has no part in the valve's bench", right)
            if key in [free.key for free in found]:
                raise InvalidValue(f"{key} is given twice", "give it once")
            own = float(leaves[key].default)
            found.append(_free(key, declaration, own, bounds if given else None, machine.ambient.pressure, method))
        except InvalidValue as wrong:
            all_faults.append(Fault(*where, wrong.wrong, wrong.right))
    if not texts:
        right = f"write {where[1]} {EXAMPLE}" if where == COMMAND_LINE else f'write {where[1]}=["{EXAMPLE}"]'
        all_faults.append(Fault(*where, "is not given", right))
    if all_faults:
        raise InputError(all_faults)
    return found


def _on_bench(key: str) -> bool:
    """Whether a key of the machine has a part in a run of the valve's bench."""
    section, name, *_ = key.split(".")
    return section in BENCH or (section == "effects" and name in ValveEffects._fields)


def _free(
    key: str, declaration: Quantity, value: float, bounds: str | None, ambient_pressure: float, method: str
) -> Free:
    """One free parameter; raises `InvalidValue`."""
    low, high = declaration.ends
    if bounds is not None:
        right = f"write {key}=LOW:HIGH, each with its unit, within {declaration.range_text}"
        ends = bounds.split(":")
        if len(ends) != 2:
            raise InvalidValue(f"{quoted(bounds)} are no bounds", right)
        try:
            low, high = (declaration.read(end.strip(), ambient_pressure) for end in ends)
        except InvalidValue as wrong:
            raise InvalidValue(wrong.wrong, wrong.right or right) from None
        if not low < high < inf:
            raise InvalidValue(f"{quoted(bounds)}: the first is not below the second", right)
    elif method == GENETIC and key in PAPER_RANGES:
        low, high = PAPER_RANGES[key]
    elif not high - low < inf:
        raise InvalidValue(f"{key} has no range of its own", f"write {key}=LOW:HIGH")
    local = bounds is None and method != GENETIC and low < value < high and value != 0.0
    start = value if low < value < high else 0.5 * (low + high)
    scale = abs(value) if local else 0.5 * (high - low)
    return Free(key, declaration, low, high, start, scale, local)
