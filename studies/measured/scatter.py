"""Table ``[scatter]`` of measured data: by how much numbers of a rig differ from run to run."""

from collections.abc import Mapping
from typing import Any

from apesim.engine.stated_uncertainties import read_deviations
from apesim.quantities import Fault, InvalidValue
from apesim.quantities.uncertainties import Uncertainty
from apesim.studies.measured.runs import CYLINDER, Bench

SCATTER = "scatter"
"""Name of the table."""
SCATTERING = "supply.pressure", "supply.temperature", "valve.viscous_friction", "valve.solenoid.dead_time"
"""What may scatter: the supply by its regulator and its store, friction by grease and seals, dead time by the coil."""
EXAMPLE = '"supply.pressure" = "0.3 %"'


def read_scatter(file: str, table: Any, bench: Bench) -> tuple[dict[str, Uncertainty], list[Fault]]:
    """Read the table of scatter of a folder: standard deviations between runs by key, as ``[known_to]`` has them.

    `file` is where it stands, for messages. Returns the scatter by the key of the machine file, and the faults; the
    cylinder's bench has nothing that scatters.

    >>> read_scatter("measured.toml", {"supply.pressure": "0.3 %"}, Bench.VALVE)[0]
    {'supply.pressure': Uncertainty(deviation=0.003, is_share=True)}
    >>> print(*read_scatter("measured.toml", {"valve.stroke": "1 %"}, Bench.VALVE)[1])  # doctest: +ELLIPSIS
    measured.toml: scatter.valve.stroke: is no number that may scatter; write supply.pressure, ...
    """
    if table and bench == CYLINDER:
        return {}, [Fault(file, SCATTER, f"cannot matter on the {bench}'s bench", "leave it out")]
    scatter, wrong = read_deviations(table, f"write [{SCATTER}] and {EXAMPLE}", SCATTERING, _find_unknown)
    return scatter, [Fault(file, f"{SCATTER}.{name}".rstrip("."), each.wrong, each.right) for name, each in wrong]


def _find_unknown(_: str, named: Mapping[str, str]) -> InvalidValue:
    *others, last = named
    return InvalidValue("is no number that may scatter", f"write {', '.join(others)} or {last}")
