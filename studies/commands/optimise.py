"""Command `apesim engine optimise`."""

from apesim.engine.steady import run_steady
from apesim.quantities import Choice, Culprit, InputError, parse, parse_range
from apesim.studies.commands.archived import computed, summary
from apesim.studies.commands.fit import free_parameters
from apesim.studies.commands.given import SPEED
from apesim.studies.commands.tables import number, table_of
from apesim.studies.commands.timing import machine_with_targets
from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.optimise.landscape import Goal
from apesim.studies.optimise.table import (
    BOUNDS,
    NAMES,
    archive_of,
    bounds_of,
    faults_of,
    optima_over_speed,
    row_of,
    speed_rpm,
)

GOALS = ("torque", "air", "both")
GOAL = Choice(GOALS, "command line")
FREE_KEY = "supply.pressure"
HEADER = (
    *("speed\n[r/min]", "commands", "energise\n[deg]", "release\n[deg]", "supply\n[MPa gauge]", "opens\n[deg]"),
    *("closes\n[deg]", "peak lift\n[mm]", "full lift", "brake torque\n[N m]", "all air\n[kg/kWh]"),
)


def optimise_command(console, machine_file, settings, goal, speed, free, out, jobs, overwrite, figures):
    """The best commands over speed; see `apesim engine optimise --help`.

    Returns
    -------
    int
        Exit code.
    """
    from apesim.studies.figures.optimise import optimise_figures

    machine = machine_with_targets(machine_file, settings, None)
    goal = GOALS[parse(goal, GOAL, where="--for", file=COMMAND_LINE)]
    goals = tuple(Goal) if goal == "both" else (Goal[goal.upper()],)
    speeds = parse_range(speed, SPEED, where="--speed", file=COMMAND_LINE)
    pressures = _pressures(machine, free)
    optima = []

    def compute(command, report):
        optima.extend(optima_over_speed(machine, speeds, goals, pressures, jobs, report))
        return archive_of(machine, optima, goals, pressures, command)

    def draw(archive, folder):
        return optimise_figures(archive, machine.ambient.pressure, folder) if figures else []

    archive, told = computed(console, "optimise", (run_steady, machine, speeds[0]), compute, out, overwrite, draw)
    faults = faults_of(optima)
    stated = {key: text for key, text in archive.provenance.items() if key.startswith(("criterion", "searched_"))}
    data = {"for": goal, **stated, "points": [_point(one) for one in optima], "faults": faults}
    rows = [row for one in optima for row in _rows(one, machine.ambient.pressure)]
    counted = ", ".join(f"{sum(getattr(one, name) for one in optima)} {name}" for name in ("sketches", "runs"))
    where = summary(told, f"{len(optima)} speeds, {counted},")
    console.result(data | told, table_of("The best commands", HEADER, rows, left=(1, 8)), *_ends(optima), where)
    for fault in faults:
        console.message(f"warning: {fault}")
    return INCOMPLETE if faults else DONE


def _pressures(machine, free):
    """Both ends of a supply pressure set free, or None [Pa abs]."""
    if free is None:
        return None
    form = f"write {FREE_KEY}=0.5 MPa gauge:1.5 MPa gauge"
    key, equals, _ = free.partition("=")
    if key.strip() != FREE_KEY or not equals:
        wrong = f"{free!r} is not the supply pressure with its bounds"
        raise InputError([Culprit(COMMAND_LINE, "--free", wrong, form)])
    (found,) = free_parameters(machine, [free])
    return found.low, found.high


def _point(one):
    """What was found at a speed, for JSON."""

    def told(point):
        return row_of(point) | {"full_lift": point.full_lift} if point else None

    found = {"speed_rpm": speed_rpm(one), "uncorrected": told(one.own)}
    for goal, point in one.best.items():
        bounds = {name: BOUNDS[code] for name, code in bounds_of(point).items() if code}
        found[NAMES[goal]] = told(point) | {"bounds": bounds} if point else None
    return found | {"front": [told(point) for point in one.front], "sketches": one.sketches, "runs": one.runs}


def _rows(one, ambient_pressure):
    """A row for the machine's own commands and one for each goal."""
    points = {"uncorrected": one.own} | {NAMES[goal]: point for goal, point in one.best.items()}
    for name, point in points.items():
        row = row_of(point)
        yield (
            f"{speed_rpm(one):g}",
            name.replace("_", " "),
            number(row["energise_deg"], ".2f"),
            number(row["release_deg"], ".2f"),
            number((row["supply_pressure"] - ambient_pressure) / 1e6, ".3f"),
            number(row["valve_open_deg"], ".2f"),
            number(row["valve_close_deg"], ".2f"),
            number(row["peak_lift_m"] * 1e3, ".3f"),
            ("yes" if point.full_lift else "no") if point else "-",
            number(row["brake_torque_Nm"], ".2f"),
            number(row["specific_air_kg_per_kWh"], ".1f"),
        )


def _ends(optima):
    """A line on each optimum that lies at an end of the range searched."""
    for one in optima:
        for goal, point in one.best.items():
            for key, code in bounds_of(point).items():
                if code:
                    what = f"{speed_rpm(one):g} r/min, {NAMES[goal].replace('_', ' ')}"
                    yield f"{what}: at the {BOUNDS[code]} {key.replace('_', ' ')} searched"
