"""Command `apesim engine run`."""

from typing import TYPE_CHECKING, Annotated

import typer

from apesim.studies.commands.options import Common, Traces, as_options
from apesim.studies.terminal.console import DONE, INCOMPLETE

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
COLD = "lowest_cylinder_temperature_K", "exhaust_temperature_K"
"""Numbers that say how cold the air comes to be."""


def run_engine(
    common: Common, speed: Annotated[str, typer.Option(metavar="N", help='E.g. "1000 rpm".')], csv: Traces = None
) -> int:
    """One operating point at its periodic steady state."""
    import numpy as np

    from apesim.archive import find_target
    from apesim.engine.cycle.cylinder_laws import TRACE
    from apesim.engine.indicators import ADIABATIC, is_adiabatic
    from apesim.results import NotConverged
    from apesim.studies.execution.output import write_traces
    from apesim.studies.run import engine_run
    from apesim.studies.terminal.tables import number, table_of

    console, machine = common.console, common.load_machine()

    # A file that cannot be written is refused before anything is marched.
    if csv:
        find_target(csv)

    # A run that does not settle is shown all the same: its closures say how far off it is.
    try:
        with as_options("run_engine"):
            run = console.run("to the periodic state", engine_run.run_engine, machine, speed=speed)
    except NotConverged as error:
        run = error.result
    data, orbit = run.to_dict(), run.march.orbit
    if csv:
        samples = np.column_stack((run.traces["crank_angle_deg"], run.march.trace))
        write_traces(csv, ("crank_angle [deg]", *TRACE), samples)

    # Where no wall gives heat to the air, the cold temperatures are a limit, and their rows say so.
    limit = f", {ADIABATIC}" if is_adiabatic(machine) else ""
    rows = [(name + limit * (key in COLD), number(run[key] * factor), unit) for name, key, factor, unit in SHOWN]
    title = f"{run.conditions['intake']} at {run['speed_rpm']:g} r/min"

    # How far the numbers can be trusted: by the cycles, the balances, and a march at tenfold tolerance.
    closes = (
        f"{orbit.cycles} cycles to a period of {orbit.period}, last change {orbit.change:.1e}; closure of "
        f"mass {run['mass_closure']:.1e}, of energy {run['energy_closure']:.1e}, of exergy "
        f"{run['exergy_closure']:.1e}; work by quadrature {run['work_by_quadrature_change']:.1e}, at tenfold "
        f"tolerance {run['work_tolerance_change']:.1e}, air {run['air_tolerance_change']:.1e}; "
        f"tolerance {run.march.tolerance:g}; {run['wall_time'] * 1e3:.0f} ms"
    )
    console.result(
        data, table_of(title, ("", "value", "unit"), rows), _exergy_table(data["exergy_J_per_cycle"]), closes
    )
    for warning in run.warnings:
        console.message(f"warning: {warning}")
    return DONE if run.converged else INCOMPLETE


def _exergy_table(ledger: dict[str, float]) -> "Table":
    """Table of an exergy ledger; a term of less than a millionth of what enters is left out."""
    from apesim.engine.exergy import ENTERS, LEAVES, exergy_entering
    from apesim.studies.terminal.tables import table_of

    entering = exergy_entering(ledger)
    prefix = dict.fromkeys(ENTERS, "in: ") | dict.fromkeys(LEAVES, "lost: ")
    rows = [
        (prefix.get(name, "") + name.replace("_", " "), f"{term:.2f}", f"{term / entering:.1%}" if entering else "-")
        for name, term in ledger.items()
        if abs(term) > 1e-6 * entering
    ]
    return table_of("exergy in a cycle, against the ambient", ("", "J", "of what enters"), rows)
