"""How far numbers of a machine are known: the table ``[known_to]`` of a machine file, or of measured data."""

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from math import isfinite, isnan
from typing import Any

from apesim.quantities import InvalidValue, Quantity, quoted
from apesim.quantities.declarations import Declaration
from apesim.quantities.input_errors import MAX_NAMED
from apesim.quantities.trees import Leaf, schema
from apesim.quantities.uncertainties import Uncertainty, flatten, format_uncertainty, read_uncertainty

KNOWN_TO = "known_to"
"""Name of the table."""
GAIN, OFFSET = "effects.sensor_gain.", "effects.sensor_offset."
"""What the keys of the machine file begin with that say what sensors read more."""
STATED_BY_RUNS = ("supply.control_pressure", f"{GAIN}supply_pressure", f"{OFFSET}supply_temperature")
"""Keys that measured runs overrule, or that stand for how far their supply is known."""
RARELY_MEANT = "effects.", "stage_2."
"""What the keys begin with that a name without its section rarely means."""
SECOND_EXHAUST = "engine.exhaust_2."
"""What the keys of the second exhaust valve begin with, which a machine need not have."""
VALVE_IS_OFF = (
    "is of a second exhaust valve that is off",
    f"switch it on by {SECOND_EXHAUST}effective_area in the machine file, or leave it out",
)
"""Fault of a number of that valve: wrong, right."""
AS_SHARE = "supply.pressure"
"""Key of which a share alone can be said: that of the pressure above ambient, as a gauge errs."""
MIN_LIKENESS = 0.8
"""Likeness, by `difflib`, from which one name is meant; below it, names that end alike are told, too."""
EXAMPLE = '"valve.stroke" = "0.05 mm"'


@cache
def list_leaves() -> dict[str, Leaf]:
    """List the numbers of a machine file of which it can be said how far they are known, by key."""
    return {
        key: leaf
        for key, leaf in _list_all_leaves().items()
        if isinstance(leaf.declaration, Quantity) and not leaf.declaration.whole and key not in STATED_BY_RUNS
    }


def _list_all_leaves() -> dict[str, Leaf]:
    from apesim.engine.machine import Machine  # which declares a table of them

    return {leaf.key: leaf for leaf in schema(Machine)}


def name_key(key: str) -> str:
    """Name a number of the machine file as the table ``[known_to]`` does: a sensor's gain and offset by the sensor."""
    for start, name in ((GAIN, "gain"), (OFFSET, "offset")):
        if key.startswith(start):
            return f"sensor.{key.removeprefix(start)}.{name}"
    return key


def read_known_to(table: Any) -> tuple[dict[str, Uncertainty], list[tuple[str, InvalidValue]]]:
    """Read a table ``[known_to]``: the standard deviations by key of the machine file, and the faults.

    The dots of a key are in quotes or not. A fault is the key as the table has it, and what is wrong with it.

    >>> known_to, faults = read_known_to({"valve.stroke": "1 %", "sensor.lift.gain": "0.2 %", "valve.strok": "1 %"})
    >>> known_to["valve.stroke"], known_to["effects.sensor_gain.lift"]
    (Uncertainty(deviation=0.01, is_share=True), Uncertainty(deviation=0.002, is_share=False))
    >>> faults[0][1].right
    'did you mean valve.stroke?'
    """
    return read_deviations(table, f"write [{KNOWN_TO}] and {EXAMPLE}", list_leaves(), _find_unknown)


def read_deviations(
    table: Any, right: str, keys: Iterable[str], find_unknown: Callable[[str, Mapping[str, str]], InvalidValue]
) -> tuple[dict[str, Uncertainty], list[tuple[str, InvalidValue]]]:
    """Read a table of standard deviations of numbers of a machine file: these by key, and the faults.

    The dots of a key are in quotes or not; `right` says what to write where `table` is no table. `keys` are those that
    it takes; `find_unknown` finds what is wrong with another key, from it and from the right ones by their names. A
    fault is the key as the table has it, and what is wrong with it.
    """
    if not isinstance(table, Mapping):
        return {}, [("", InvalidValue(f"{quoted(table)} is no table", right))]
    leaves, named = list_leaves(), {name_key(key): key for key in keys}
    deviations: dict[str, Uncertainty] = {}
    faults: list[tuple[str, InvalidValue]] = []
    strange: list[str] = []
    for name, raw in flatten(table):
        key = named.get(name)
        if key is None:
            strange.append(name)
        elif key in deviations:
            faults.append((name, InvalidValue("is given twice", "give it once")))
        else:
            try:
                deviations[key] = _read_one(key, raw, leaves[key])
            except InvalidValue as wrong:
                faults.append((name, wrong))
    faults += [(name, find_unknown(name, named)) for name in strange[:MAX_NAMED]]
    if (more := len(strange) - MAX_NAMED) > 0:
        faults.append(("", InvalidValue(f"{more} more unknown keys", f"mend the first {MAX_NAMED} of them")))
    return deviations, faults


def _read_one(key: str, raw: Any, leaf: Leaf) -> Uncertainty:
    """Standard deviation of a number; that of a sensor's gain is a share of what it reads."""
    uncertainty = read_uncertainty(raw, leaf.declaration, leaf.default)
    if key == AS_SHARE and uncertainty.deviation and not uncertainty.is_share:
        wrong = f"{quoted(raw)} is no share"
        raise InvalidValue(wrong, 'write a share of the pressure above ambient, as a gauge errs, e.g. "1 %"')
    return uncertainty._replace(is_share=False) if key.startswith(GAIN) else uncertainty


def _find_unknown(name: str, named: Mapping[str, str]) -> InvalidValue:
    """What is wrong with an unknown key, and the nearest right one."""
    if name in named.values():
        return InvalidValue("is named by its sensor here", f"write {name_key(name)}")
    if name in STATED_BY_RUNS:
        return InvalidValue("is what runs state", "write supply.pressure or supply.temperature")
    if name in _list_all_leaves():
        return InvalidValue("is no number that can be known within a standard deviation", "leave it out")
    last = name.rpartition(".")[2]
    near = difflib.get_close_matches(name, named, n=1)
    alike = [key for key in named if key.endswith(f".{last}") and not key.startswith(RARELY_MEANT)]
    is_clear = near and difflib.SequenceMatcher(None, name, near[0]).ratio() > MIN_LIKENESS
    keys = near if is_clear else alike[:3] or near
    right = f"did you mean {' or '.join(keys)}?" if keys else "write a key of the machine file, or sensor.lift.gain"
    return InvalidValue("unknown key", right)


def format_known_to(key: str, uncertainty: Uncertainty) -> str:
    """Write how far a number, by its key of the machine file, is known, as the table has it.

    >>> format_known_to("effects.sensor_gain.lift", Uncertainty(2e-3))
    '0.2 %'
    """
    is_share = uncertainty.is_share or key.startswith(GAIN)
    return format_uncertainty(uncertainty._replace(is_share=is_share), list_leaves()[key].declaration)


@dataclass(frozen=True)
class KnownTo(Declaration):
    """Standard deviations within which numbers of the machine are known; inside pairs of key and `Uncertainty`.

    Nothing that is simulated reads them: they say what the search for a missing effect may move, and by how much.
    `source` says where such numbers come from.
    """

    source: str
    is_table = True
    entry = EXAMPLE

    @property
    def range_text(self) -> str:
        """The form of the table."""
        return f"standard deviations, such as {EXAMPLE}"

    @property
    def strong(self) -> str:
        """A right form in TOML."""
        return f"{{ {EXAMPLE} }}"

    def read(
        self, raw: Any, ambient_pressure: float | None = None, folder: Any = None
    ) -> tuple[tuple[str, Uncertainty], ...]:
        """Return the pairs of key and `Uncertainty` of a table, see `read_known_to`; the other arguments are unused.

        Raises InvalidValue whose ``parts`` have every fault.
        """
        known_to, faults = read_known_to(raw)
        if faults:
            _, first = faults[0]
            raise InvalidValue(first.wrong, first.right, tuple(faults))
        return tuple(known_to.items())

    def _converted(self, value: Any) -> tuple[Any, ...]:
        """Convert a checked table to a tuple, see `Declaration.convert`."""
        return value if isinstance(value, tuple) else tuple(value)

    def check(self, value: Any) -> None:
        """Refuse pairs, made in Python, that no table could have given: raises InvalidValue.

        They are no pairs, or the text of one is refused.
        """
        try:
            self.read({name_key(key): format_known_to(key, Uncertainty(*pair)) for key, pair in value})
        except (TypeError, ValueError, KeyError) as error:
            wrong = error if isinstance(error, InvalidValue) else InvalidValue(f"{quoted(value)} are no pairs")
            raise InvalidValue(
                wrong.wrong, wrong.right or f"give a mapping, such as {{{EXAMPLE.replace(' =', ':')}}}"
            ) from None

    def render(
        self, value: tuple[tuple[str, Uncertainty], ...], ambient_pressure: float | None = None
    ) -> dict[str, str] | str:
        """Return the table of texts by key that reads back as pairs; "" for none. `ambient_pressure` is unused."""
        return {name_key(key): format_known_to(key, pair) for key, pair in value} or ""

    def example(self, value: Any, ambient_pressure: float | None = None) -> str:
        """Return a right form for a message; the arguments are unused."""
        return f"write [{KNOWN_TO}] and {EXAMPLE}"


def is_of_absent_valve(machine: Any, key: str) -> bool:
    """Whether a number, by its key of the machine file, is of a second exhaust valve that a machine does not have."""
    return key.startswith(SECOND_EXHAUST) and not machine.engine.exhaust_2.is_on


def find_odd_share(machine: Any, key: str, uncertainty: Uncertainty) -> tuple[str, str] | None:
    """Find whether a machine has no such number, or one of which no share can be taken: wrong, right; None if neither.

    >>> from apesim.engine.machine import Machine
    >>> find_odd_share(Machine(), "valve.solenoid.release_dead_time", Uncertainty(1e-4))
    ('the machine gives it no value', 'give it one, or leave it out here')
    """
    value = machine
    for name in key.split("."):
        value = getattr(value, name)
    if not isfinite(value):
        return (
            f"the machine gives it {'no value' if isnan(value) else 'the value inf'}",
            "give it one, or leave it out here",
        )
    if uncertainty.is_share and not value:
        if is_of_absent_valve(machine, key):
            return VALVE_IS_OFF
        unit = list_leaves()[key].declaration.unit
        return "is a share of 0", f"write a number{' of ' * bool(unit)}{unit}"
    return None


def find_odd_shares(machine: Any) -> Iterator[tuple[str, str, str]]:
    """Find what a machine states of numbers that it lacks, or of which no share can be taken: key, wrong, right.

    >>> from apesim.engine.machine import Machine
    >>> machine = Machine(known_to=(("engine.pin_offset", Uncertainty(0.01, is_share=True)),))
    >>> list(find_odd_shares(machine))
    [('known_to.engine.pin_offset', 'is a share of 0', 'write a number of mm')]
    """
    for key, uncertainty in machine.known_to:
        if fault := find_odd_share(machine, key, uncertainty):
            yield f"{KNOWN_TO}.{name_key(key)}", *fault
