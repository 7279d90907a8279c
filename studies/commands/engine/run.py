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
    ("torque ripple", "torque_ripple", 100.0, "%"),
    ("receiver's dip below the supply", "receiver_dip_Pa", 1e-3, "kPa"),
    ("lowest speed", "lowest_speed_rpm", 1.0, "r/min"),
    ("highest speed", "highest_speed_rpm", 1.0, "r/min"),
)
COLD = "lowest_cylinder_temperature_K", "exhaust_temperature_K"
"""Numbers that say how cold the air comes to be."""


def run_engine(
    common: Common,
    speed: Annotated[str, typer.Option(metavar="N", help='E.g. "1000 rpm".')],
    free: Annotated[bool, typer.Option("--free", help="Let the shaft go at that speed, against the load.")] = False,
    csv: Traces = None,
) -> int:
    """One operating point at its periodic steady state."""
    from apesim.archive import find_target
    from apesim.engine.drivetrain.indicators import VALVE_INDICATORS
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
            run = console.run("to the periodic state", engine_run.run_engine, machine, speed=speed, free=free)
    except NotConverged as error:
        run = error.result
    data, orbit = run.to_dict(), run.march.orbit
    if csv:
        write_traces(csv, *engine_run.trace_table(run))

    # Where no wall gives heat to the air, the cold temperatures are a limit, and their rows say so.
    limit = f", {ADIABATIC}" if is_adiabatic(machine) else ""
    rows = [
        (name + limit * (key in COLD), number(run[key] * factor), unit)
        for name, key, factor, unit in SHOWN
        if key in data
    ]
    title = f"{run.conditions['intake']} at {run['speed_rpm']:.6g} r/min" + ", free shaft" * free
    tables = [table_of(title, ("", "value", "unit"), rows)]

    # What is of one valve is told of each; the exergy of one cylinder at constant speed is accounted for.
    count = len(run.cylinders)
    if count > 1:
        own = [
            (f"{name} [{unit}]", *(number(each[key] * factor) for each in run.cylinders))
            for name, key, factor, unit in SHOWN
            if key in VALVE_INDICATORS
        ]
        tables.append(table_of("each cylinder", ("", *map(str, range(1, count + 1))), own))
    elif not free:
        tables.append(_exergy_table(data["exergy_J_per_cycle"]))

    # How far the numbers can be trusted: by the cycles, the balances, and a march at tenfold tolerance.
    is_shaft = count > 1 or free
    exergy = "" if is_shaft else f", of exergy {run['exergy_closure']:.1e}"
    closes = (
        f"{orbit.cycles} cycles to a period of {orbit.period}, last change {orbit.change:.1e}; closure of "
        f"mass {run['mass_closure']:.1e}, of energy {run['energy_closure']:.1e}{exergy}; "
        f"work by quadrature {run['work_by_quadrature_change']:.1e}, at tenfold "
        f"tolerance {run['work_tolerance_change']:.1e}, air {run['air_tolerance_change']:.1e}; "
        f"tolerance {run.march.tolerance:g}; {run['wall_time'] * 1e3:.0f} ms"
    )
    lines = [closes]
    if "speed_swing" in run:
        lines.append(
            f"constant speed: with shaft.inertia {machine.shaft.inertia:g} kg m^2 it would swing by some "
            f"{run['speed_swing']:.1%} of its mean, see --free"
        )
    console.result(data, *tables, *lines)
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
