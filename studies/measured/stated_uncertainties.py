"""Table ``[known_to]`` of measured data: how far the numbers are known on which data of a bench depend."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from apesim.engine.stated_uncertainties import GAIN, KNOWN_TO, OFFSET, name_key, read_known_to
from apesim.quantities import Fault
from apesim.quantities.uncertainties import Uncertainty
from apesim.studies.measured.runs import CYLINDER, ENGINE, VALVE, Bench, MeasuredRun
from apesim.studies.measured.sensors import SENSORS
from apesim.valve.effects import VALVE_EFFECTS
from apesim.valve.rig import RIG_EFFECTS

SECTIONS = {
    VALVE: ("air", "ambient", "supply", "valve"),
    ENGINE: ("air", "ambient", "supply", "valve", "groove", "engine"),
    CYLINDER: ("ambient", "rig"),
}
"""Sections of the machine file that a bench depends on, beside its effects."""


def read_table(file: str, table: Any, bench: Bench) -> tuple[dict[str, Uncertainty], list[Fault]]:
    """Read the table ``[known_to]`` of a folder that says how well numbers are known, by machine key.

    `table` holds its contents, see `apesim.engine.stated_uncertainties.read_known_to`; a key that cannot matter on the
    bench is refused.

    >>> print(*read_table("measured.toml", {"engine.bore": "1 %"}, VALVE)[1])
    measured.toml: known_to.engine.bore: cannot matter on the valve's bench; leave it out
    """
    known_to, wrong = read_known_to(table)
    faults = [Fault(file, f"{KNOWN_TO}.{name}".rstrip("."), each.wrong, each.right) for name, each in wrong]
    for key in known_to:
        if not matters(key, bench):
            place = f"{KNOWN_TO}.{name_key(key)}"
            faults.append(Fault(file, place, f"cannot matter on the {bench}'s bench", "leave it out"))
    return known_to, faults


def matters(key: str, bench: Bench) -> bool:
    """Tell whether a number of the machine file, or of a sensor, may matter on a bench."""
    section, _, rest = key.partition(".")
    if section != "effects":
        return section in SECTIONS[bench]
    effect, _, parameter = rest.partition(".")
    if key.startswith((GAIN, OFFSET)):
        return parameter in SENSORS[bench].traces | SENSORS[bench].means
    return bench == ENGINE or effect in {each.name for each in (RIG_EFFECTS if bench == CYLINDER else VALVE_EFFECTS)}


def find_absent_sensors(known_to: Mapping[str, Uncertainty], runs: Iterable[MeasuredRun]) -> Iterator[str]:
    """Find the sensors of which something is stated, and that no run has: in words, what is not used.

    `known_to` goes by the key of the machine file.

    >>> list(find_absent_sensors({"effects.sensor_gain.lift": Uncertainty(0.002)}, []))
    ['known_to."sensor.lift.gain" is not used: no run has lift']
    """
    sensors = {sensor for run in runs for sensor in (*run.channels, *run.means)}
    for key in known_to:
        sensor = key.rpartition(".")[2]
        if key.startswith((GAIN, OFFSET)) and sensor not in sensors:
            yield f'{KNOWN_TO}."{name_key(key)}" is not used: no run has {sensor}'
