"""Figures around the cycle: pressures, temperature, lift and flow, and the diagrams of p-V and T-s."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from apesim.air import gas_of, thermal_entropy
from apesim.archive import Archive
from apesim.engine.machine import Machine
from apesim.studies.report.figures.curves import Curves, Line
from apesim.studies.report.figures.labels import Axis, Frames, find_shown_unit

PANELS = (
    ("cylinder pressure", ("cylinder_pressure",)),
    ("lift of the intake", ("lift",)),
    ("chambers A and B of the valve", ("pressure_a", "pressure_b")),
    ("flow into the cylinder", ("groove_flow",)),
    ("flow out of the cylinder", ("exhaust_flow",)),
    ("torque of the gas", ("torque",)),
    ("cylinder temperature", ("cylinder_temperature",)),
    ("receiver pressure", ("receiver_pressure",)),
)
"""What is drawn over the crank angle or the time: label, and traces of the archive."""
ATMOSPHERE = 101325.0
"""Pressure at which the entropy is counted as zero [Pa abs]."""
SHORT = {"pressure_a": "A", "pressure_b": "B"}
"""Names of traces where several stand in one figure."""


class CycleLine(NamedTuple):
    """One line of all figures of the cycle: its traces for each frame, (n,) in SI, by the names of the archive."""

    label: str
    look: int
    traces: Sequence[Mapping[str, np.ndarray]]


def draw_cycle(
    archive: Archive,
    machine: Machine,
    x: Axis,
    x_values: Sequence[np.ndarray],
    lines: Sequence[CycleLine],
    frames: Frames,
) -> list[Curves]:
    """Draw all figures of the cycle over an axis, and the diagrams; what the archive has no trace of is left out."""
    figures = []
    loops = [line for line in lines if {"cylinder_volume", "cylinder_pressure"} <= set(line.traces[0])]
    if loops:
        figures.append(_draw_indicator_diagram(loops, frames))
    if loops and "cylinder_temperature" in loops[0].traces[0]:
        figures.append(_draw_temperature_entropy(loops, machine, frames))
    for label, names in PANELS:
        drawn = [(line, name) for line in lines for name in names if _is_shown(line, name)]
        if not drawn:
            continue
        factor, unit = find_shown_unit(archive.variables[names[0]].unit)
        own = [
            Line(
                f"{line.label}, {SHORT[name]}" if len(names) > 1 else line.label,
                [traces[name] * factor for traces in line.traces],
                look=line.look,
                dash=number if len(names) > 1 else None,
            )
            for number, (line, name) in enumerate(drawn)
        ]
        title = label[:1].upper() + label[1:]
        figures.append(
            Curves(
                title,
                x,
                Axis("pressure" if "chambers" in label else label, unit),
                own,
                x_values,
                sync="cycle",
                frames=frames,
            )
        )
    return figures


def _is_shown(line: CycleLine, name: str) -> bool:
    """Whether a line has a trace that has numbers; a cam has no chambers."""
    return all(name in traces and np.isfinite(traces[name]).any() for traces in line.traces)


def _draw_indicator_diagram(lines: Sequence[CycleLine], frames: Frames) -> Curves:
    """Draw pressure over volume."""
    own = [
        Line(
            line.label,
            [traces["cylinder_pressure"] * 1e-6 for traces in line.traces],
            [traces["cylinder_volume"] * 1e6 for traces in line.traces],
            line.look,
        )
        for line in lines
    ]
    note = "The area inside a loop is the indicated work of a cycle"
    return Curves(
        "p–V diagram", Axis("volume", "cm³"), Axis("pressure", "MPa abs"), own, note=note, is_loop=True, frames=frames
    )


def _draw_temperature_entropy(lines: Sequence[CycleLine], machine: Machine, frames: Frames) -> Curves:
    """Draw the temperature over the specific entropy of the air in the cylinder."""
    own = [
        Line(
            line.label,
            [traces["cylinder_temperature"] for traces in line.traces],
            [
                find_entropy(machine, traces["cylinder_pressure"], traces["cylinder_temperature"]) * 1e-3
                for traces in line.traces
            ],
            line.look,
        )
        for line in lines
    ]
    note = "Air in the cylinder; its mass changes along the loop. Zero: air at 1 atm and the ambient temperature"
    x, y = Axis("specific entropy", "kJ/(kg K)"), Axis("temperature", "K")
    return Curves("T–s diagram", x, y, own, note=note, is_loop=True, frames=frames)


def find_entropy(machine: Machine, pressure: np.ndarray, temperature: np.ndarray) -> np.ndarray:
    """Specific entropy [J/(kg K)] of air at pressures [Pa abs] and temperatures [K], above that at 1 atm and ambient.

    >>> find_entropy(Machine(), np.array([101325.0]), np.array([Machine().ambient.temperature])).tolist()
    [0.0]
    """
    gas = gas_of(machine.air)
    zero = thermal_entropy(gas, machine.ambient.temperature)
    thermal = np.array([thermal_entropy(gas, float(value)) if value > 0.0 else np.nan for value in temperature]) - zero
    with np.errstate(invalid="ignore", divide="ignore"):
        return thermal - gas.gas_constant * np.log(pressure / ATMOSPHERE)
