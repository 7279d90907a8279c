"""Machines of other people's papers, made as `apesim new` makes one: what a paper states, and the rest by rule.

Run it to write the machine files anew: ``python docs/examples/data/papers/make.py``.
"""

import textwrap
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import apesim


class Paper(NamedTuple):
    """Machine of a paper."""

    source: str
    stated: str
    """What the paper states, of what is used here."""
    derived: str
    """What follows from that, or is assumed: chosen before anything was computed."""
    answers: Mapping[str, Any]
    settings: Mapping[str, Any] = MappingProxyType({})
    """Keys of the machine file beside the answers."""


PAPERS = {
    "motorcycle": Paper(
        "C.-Y. Huang et al., Energies 2013, 6, 1731 (doi 10.3390/en6031731)",
        "100 cm3; two-stroke; cam-driven valves; supply at 9 bar abs; highest power at 1320 r/min.",
        "Bore and stroke: a square cylinder of 100 cm3. Compression ratio 9: a petrol engine's. Room temperature.",
        {
            "supply_pressure": "0.9 MPa abs",
            "supply_temperature": "293.15 K",
            "bore": "50 mm",
            "stroke": "51 mm",
            "compression_ratio": 9.0,
            "rated_speed": "1320 rpm",
        },
        {"engine.intake": "cam"},
    ),
    "prototype_2_mpa": Paper(
        "Adv. Mech. Eng. 2016 (doi 10.1177/1687814016641838)",
        "Supply at 2 MPa; 56 N m and 1.93 kW at 420 r/min, which do not agree: 56 N m are 2.46 kW there.",
        "2 MPa taken as gauge. Swept volume 352 cm3: as if the mean pressure of 56 N m, 2 pi T/V, were half of 2 MPa. "
        "A square cylinder of it. Room temperature.",
        {
            "supply_pressure": "2 MPa gauge",
            "supply_temperature": "293.15 K",
            "bore": "76.5 mm",
            "stroke": "76.5 mm",
            "rated_speed": "420 rpm",
        },
    ),
    "fast_solenoid": Paper(
        "E. E. Topcu et al., Mechatronics 16 (2006) 365: a fast on/off valve, in the default engine",
        "It switches in about 4.5 ms, and passes 460 L/min.",
        "460 L/min taken as the usual nominal flow, ANR from 0.6 to 0.5 MPa gauge; with b = 0.3 taken, C = 1.81 "
        "dm3/(s bar). Of the 4.5 ms, 3 ms taken as dead time, 1.5 ms as ramp time.",
        {
            "conductance": "1.81 dm^3/(s bar)",
            "critical_ratio": 0.3,
            "dead_time": "3 ms",
            "ramp_time": "1.5 ms",
        },
    ),
}


def design(name: str) -> Any:
    """Design the machine of a paper."""
    paper = PAPERS[name]
    return apesim.design_machine(apesim.Machine().with_(**paper.settings), **paper.answers)


def text_of(name: str) -> str:
    """Text of its machine file, with what the paper states on top."""
    paper = PAPERS[name]
    parts = paper.source, f"Stated: {paper.stated}", f"Derived or assumed: {paper.derived}"
    lines = [f"# {line}" for part in parts for line in textwrap.wrap(part, 108)]
    return "\n".join([*lines, ""]) + design(name).to_toml()


if __name__ == "__main__":
    for name in PAPERS:
        Path(__file__).with_name(f"{name}.toml").write_text(text_of(name), encoding="utf-8")
