"""Independent solutions of the valve and of the engine, printed as tables, and the results that stand beside them."""

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from apesim.engine.indicators import indicators
from apesim.engine.machine import Machine
from apesim.valve.bench import BenchRun, run_bench
from tests.machines import machine, printed, reference, settled

VALVE_ROWS, ENGINE_ROWS = reference("reference-valve.csv"), reference("reference-engine.csv")
PULSE = 50e-3
"""Time for which the solenoids are energised on the bench [s]."""
VALVE_COLUMNS: dict[str, Callable[[BenchRun], float]] = {
    "open delay [ms]": lambda run: run.opening.delay * 1e3,
    "open stroke time [ms]": lambda run: run.opening.stroke_time * 1e3,
    "open seating speed [m/s]": lambda run: run.opening.seating_speed,
    "close delay [ms]": lambda run: run.closing.delay * 1e3,
    "close stroke time [ms]": lambda run: run.closing.stroke_time * 1e3,
    "close seating speed [m/s]": lambda run: run.closing.seating_speed,
}
ENGINE_COLUMNS = {
    "indicated torque [N m]": ("indicated_torque_Nm", 1.0),
    "engine air [g/cycle]": ("engine_air_kg_per_cycle", 1e3),
    "control air [g/cycle]": ("control_air_kg_per_cycle", 1e3),
    "full open at [deg]": ("full_open_deg", 1.0),
    "closed at [deg]": ("closed_deg", 1.0),
    "opening seating speed [m/s]": ("opening_seating_speed_m_s", 1.0),
    "closing seating speed [m/s]": ("closing_seating_speed_m_s", 1.0),
    "peak lift [mm]": ("peak_lift_m", 1e3),
    "peak cylinder pressure [kPa abs]": ("peak_cylinder_pressure_Pa", 1e-3),
}
"""Names of the indicators, and factors from SI to the column's unit."""
VARIANTS = {
    "receiver 1 L": {"receiver": 1.0},
    "control air from it": {"control_air": "receiver"},
    "pin offset 5 mm": {"engine__pin_offset": 5e-3},
    "wall heat 200 W/(m2 K) at 300 K": {
        "effects__cylinder_wall_heat__h": 200.0,
        "effects__cylinder_wall_heat__wall_temperature": 300.0,
    },
    "blow-by 0.5 mm2": {"effects__blow_by__area": 0.5e-6},
}


def machine_of(row: Mapping[str, str]) -> Machine:
    """The engine of a row."""
    intake, *variants = row["case"].split("; ")
    values = {name: value for variant in variants for name, value in VARIANTS[variant].items()}
    supply, energise, release = (float(row[name]) for name in ("supply [MPa gauge]", "energise [deg]", "release [deg]"))
    return machine(intake=intake, supply=supply, energise=energise, release=release, **values)


def engine_indicators(row: Mapping[str, str]) -> dict[str, float]:
    """Indicators of the engine of a row, by name."""
    a_machine = machine_of(row)
    return indicators(a_machine, settled(a_machine, float(row["speed [rpm]"])))


def engine_results(row: Mapping[str, str]) -> dict[str, float]:
    """Results of the engine of a row, by column and in its unit."""
    found = engine_indicators(row)
    return {column: found[name] * factor for column, (name, factor) in ENGINE_COLUMNS.items()}


def valve_results(row: Mapping[str, str]) -> dict[str, float]:
    """Results of the valve of a row on its bench, by column and in its unit."""
    valve = machine(supply=float(row["supply [MPa gauge]"]), temperature=float(row["temperature [K]"]))
    run = run_bench(valve, PULSE)
    return {column: result(run) for column, result in VALVE_COLUMNS.items()}


def deviations(
    rows: list[dict[str, str]], results: Callable[[Mapping[str, str]], Mapping[str, float]]
) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Columns, each with its deviations and with half a unit of the last digit printed; empty cells are left out.

    Both are relative; of an angle in degrees.
    """
    found = [results(row) for row in rows]
    for column in found[0]:
        pairs = [(one[column], *printed(row[column])) for one, row in zip(found, rows, strict=True) if row[column]]
        values, references, halves = np.array(pairs).T
        scale = 1.0 if "[deg]" in column else np.abs(references)
        yield column, np.abs(values - references) / scale, halves / scale
