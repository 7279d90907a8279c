"""Command `apesim engine run`."""

from typing import TYPE_CHECKING, Annotated

import typer

from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.options import Common, Traces

if TYPE_CHECKING:
    from rich.table import Table

SHOWN = (
    ("brake torque", "brake_torque_Nm", 1.0, "N m"),
    ("indicated torque", "indicated_torque_Nm", 1.0, "N m"),
    ("brake power", "brake_power_W", 1e-3, "kW"),
    ("imep", "imep_Pa", 1e-5, "bar"),
    ("engine air", "engine_air_kg_per_cycle", 1e3, "g/cycle"),
    ("control air", "control_air_kg_per_cycle", 1e3, "g/cycle"),
    ("all air", "air_L_per_min_ANR", 1.0, "L/min ANR"),
    ("specific air, gross", "specific_air_kg_per_kWh", 1.0, "kg/kWh"),
    ("specific air, engine air only", "specific_engine_air_kg_per_kWh", 1.0, "kg/kWh"),
    ("exergy efficiency", "exergy_efficiency", 100.0, "%"),
    ("isothermal efficiency", "isothermal_efficiency", 100.0, "%"),
    ("isentropic efficiency", "isentropic_efficiency", 100.0, "%"),
    ("full-admission efficiency", "full_admission_efficiency", 100.0, "%"),
    ("lift crosses the lap, opening", "valve_open_deg", 1.0, "deg"),
    ("open stop", "full_open_deg", 1.0, "deg"),
    ("lift crosses the lap, closing", "valve_close_deg", 1.0, "deg"),
    ("closed stop", "closed_deg", 1.0, "deg"),
    ("peak lift", "peak_lift_m", 1e3, "mm"),
    ("seating speed, opening", "opening_seating_speed_m_s", 1.0, "m/s"),
    ("seating speed, closing", "closing_seating_speed_m_s", 1.0, "m/s"),
    ("fluctuation, opening", "fluctuation", 1.0, "-"),
    ("peak cylinder pressure", "peak_cylinder_pressure_Pa", 1e-6, "MPa abs"),
    ("intake pressure fluctuation", "intake_pressure_fluctuation_Pa", 1e-3, "kPa"),
    ("lowest cylinder temperature", "lowest_cylinder_temperature_K", 1.0, "K"),
    ("exhaust temperature, mixed", "exhaust_temperature_K", 1.0, "K"),
)
CLOSURES = {
    "mass": "mass_closure",
    "energy": "energy_closure",
    "exergy": "exergy_closure",
    "work_by_quadrature": "work_by_quadrature_change",
    "work_at_tenfold_tolerance": "work_tolerance_change",
    "air_at_tenfold_tolerance": "air_tolerance_change",
}


def run_engine(
    common: Common, speed: Annotated[str, typer.Option(metavar="N", help='E.g. "1000 rpm".')], csv: Traces = None
) -> int:
    """One operating point at its periodic steady state."""
    import time

    import numpy as np

    from apesim.engine.angles import DEGREE
    from apesim.engine.cycle.rates import TRACE
    from apesim.engine.cylinder import INTAKES
    from apesim.engine.exergy import TERMS
    from apesim.engine.indicators import COUNTS, FLAGS, INDICATORS, indicators
    from apesim.engine.steady import run_steady
    from apesim.engine.warnings import judge_point
    from apesim.march.adaptive import Status
    from apesim.quantities import parse
    from apesim.studies.operating_conditions import SPEED
    from apesim.studies.output import write_traces
    from apesim.studies.tables import number, table_of

    console, machine = common.console, common.load_machine()
    speed = parse(speed, SPEED, where="--speed", file=COMMAND_LINE)
    console.warm_up(run_steady, machine, speed, max_cycles=1)
    start = time.perf_counter()
    run = console.run("to the periodic state", run_steady, machine, speed)
    values = indicators(machine, run) if run.status == Status.DONE else dict.fromkeys(INDICATORS, float("nan"))
    wall = time.perf_counter() - start
    warnings = [f"the march ended early: {Status(run.status).remedy}"]
    if run.status == Status.DONE:
        warnings = list(judge_point(machine, run, values).values())
    data = {name: value for name, value in values.items() if name not in CLOSURES.values()}
    ledger = {name: data.pop(f"exergy_{name}_J") for name in TERMS}
    data["exergy_J_per_cycle"] = ledger
    data |= {name: bool(data[name] == 1) for name in FLAGS}
    data |= {name: int(np.nan_to_num(data[name])) for name in COUNTS}
    data["closure"] = {name: values[key] for name, key in CLOSURES.items()}
    data |= {"wall_time_s": wall, "warnings": warnings}
    if csv:
        rows = np.column_stack((run.angles / DEGREE, run.trace))
        write_traces(csv, ("crank_angle [deg]", *TRACE), rows)
    rows = [(name, number(values[key] * factor), unit) for name, key, factor, unit in SHOWN]
    title = f"{INTAKES[machine.engine.intake]} at {values['speed_rpm']:g} r/min"
    closes = (
        f"{run.orbit.cycles} cycles to a period of {run.orbit.period}, last change {run.orbit.change:.1e}; closure of "
        f"mass {values['mass_closure']:.1e}, of energy {values['energy_closure']:.1e}, of exergy "
        f"{values['exergy_closure']:.1e}; work by quadrature {values['work_by_quadrature_change']:.1e}, at tenfold "
        f"tolerance {values['work_tolerance_change']:.1e}, air {values['air_tolerance_change']:.1e}; "
        f"tolerance {run.tolerance:g}; {wall * 1e3:.0f} ms"
    )
    console.result(data, table_of(title, ("", "value", "unit"), rows), exergy_table(ledger), closes)
    for warning in warnings:
        console.message(f"warning: {warning}")
    return DONE if run.status == Status.DONE and run.orbit.converged else INCOMPLETE


def exergy_table(ledger: dict[str, float]) -> "Table":
    """Table of an exergy ledger; a term of less than a millionth of what enters is left out.

    Parameters
    ----------
    ledger : dict
        See `apesim.engine.exergy.exergy_ledger`.

    Returns
    -------
    rich.table.Table
    """
    from apesim.engine.exergy import ENTERS, LEAVES, exergy_entering
    from apesim.studies.tables import table_of

    entering = exergy_entering(ledger)
    prefix = dict.fromkeys(ENTERS, "in: ") | dict.fromkeys(LEAVES, "lost: ")
    rows = [
        (prefix.get(name, "") + name.replace("_", " "), f"{term:.2f}", f"{term / entering:.1%}" if entering else "-")
        for name, term in ledger.items()
        if abs(term) > 1e-6 * entering
    ]
    return table_of("exergy in a cycle, against the ambient", ("", "J", "of what enters"), rows)
