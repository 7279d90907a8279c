"""Command `apesim engine assess`."""

import numpy as np

from apesim.quantities import Culprit, InputError, parse_range
from engine.steady import run_steady
from studies.commands.archived import computed, summary
from studies.commands.given import SPEED
from studies.commands.tables import number, table_of
from studies.commands.timing import machine_with_targets
from studies.console import COMMAND_LINE, DONE, INCOMPLETE

HEADINGS = ("ideal", "delay", "speed", "fluct.", "control", "real")
BESIDE = (
    ("energise_deg", 1.0, ".1f", "on"),
    ("release_deg", 1.0, ".1f", "off"),
    ("valve_open_deg", 1.0, ".2f", "opens"),
    ("valve_close_deg", 1.0, ".2f", "closes"),
    ("peak_lift_m", 1e3, ".2f", "lift [mm]"),
    ("fluctuation", 1.0, ".3f", "opening"),
    ("closing_fluctuation", 1.0, ".3f", "closing"),
    ("intake_pressure_fluctuation_Pa", 1e-5, ".3f", "intake [bar]"),
    ("cycle_to_cycle_torque_Nm", 1.0, ".1e", "cycles [N m]"),
    ("period_cycles", 1.0, ".0f", "period"),
)
BESIDE_TITLE = (
    "The real valve: commands and true angles [deg]; fluctuation of both strokes, of the intake's pressure, and of the "
    "torque from cycle to cycle"
)
EXPLAINED = (
    "ideal: full groove area at once, from one intended angle to the other; real: the EPV with its control air; "
    "between them what delay, finite speed, fluctuation and control air cost: torque lost, air added, a gain negative"
)


def assess_command(console, machine_file, settings, speed, timing, out, overwrite, figures):
    """An assessment over speed; see `apesim engine assess --help`.

    Returns
    -------
    int
        Exit code.
    """
    from studies.assessment.grid import TIMINGS, assess_speeds, faults_of_assessment, undefined_ratios
    from studies.figures.assessment import assessment_figures

    machine = machine_with_targets(machine_file, settings, None)
    speeds = parse_range(speed, SPEED, where="--speed", file=COMMAND_LINE)
    if timing not in TIMINGS:
        right = f"write {' or '.join(TIMINGS)}"
        raise InputError([Culprit(COMMAND_LINE, "--timing", f"{timing!r} is no timing", right)])

    def compute(**options):
        return assess_speeds(machine, speeds, timing, **options)

    def draw(archive, folder):
        return assessment_figures(archive, folder) if figures else []

    first = run_steady, machine, speeds[0]
    archive, told = computed(console, "assessment", first, compute, out, overwrite, draw)
    faults, warnings = faults_of_assessment(archive), undefined_ratios(archive)
    data = {"points": points_of(archive), "faults": faults, "warnings": warnings} | told
    console.result(data, *tables_of(archive), EXPLAINED, summary(told, f"{len(speeds)} points"))
    for line in faults + warnings:
        console.message(f"warning: {line}")
    return INCOMPLETE if faults else DONE


def points_of(archive):
    """What an assessment tells as JSON.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    list of dict
        For each point its scalars, ``links`` with the measures of each valve of the chain, and ``losses`` with what
        each cause costs and the ``whole``.
    """
    from studies.assessment.chain import LOSSES, MEASURES, Outcome

    v = {name: variable.values for name, variable in archive.variables.items()}
    points = []
    for run, outcome in enumerate(v["outcome"]):
        scalars = {name: v[name][run] for name in v if archive.variables[name].dims == ("run",) and name != "run"}
        links = [{name: v[name][run, i] for name in MEASURES} for i in range(len(v["link"]))]
        losses = [{name: v[name][run, i] for name in LOSSES} for i in range(len(v["cause"]))]
        changes = zip(LOSSES.items(), MEASURES, strict=True)
        whole = {lost: sign * (v[name][run, -1] - v[name][run, 0]) for (lost, sign), name in changes}
        points.append(
            scalars
            | {
                "outcome": Outcome(outcome).name.lower(),
                "links": dict(zip(v["link"].tolist(), links, strict=True)),
                "losses": dict(zip(v["cause"].tolist(), losses, strict=True)) | {"whole": whole},
            }
        )
    return points


def tables_of(archive):
    """Torque and specific air along the chain, and what stands beside it.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    list of rich.table.Table
    """
    v = {name: variable.values for name, variable in archive.variables.items()}
    speeds = [f"{speed:g}" for speed in v["speed_rpm"]]

    def along(name, lost, digits):
        for run, speed in enumerate(speeds):
            values = np.array([v[name][run, 0], *v[lost][run], v[name][run, -1]]).round(digits) + 0.0  # no -0.00
            yield [speed, *(number(value, f".{digits}f") for value in values)]

    beside = [
        [speed, *(number(v[name][run] * factor, form) for name, factor, form, _ in BESIDE)]
        for run, speed in enumerate(speeds)
    ]
    header = ("r/min", *HEADINGS)
    torque = along("brake_torque_Nm", "brake_torque_lost_Nm", 2)
    air = along("specific_air_kg_per_kWh", "specific_air_added_kg_per_kWh", 1)
    return [
        table_of("Brake torque, and what of it is lost [N m]", header, torque, left=()),
        table_of("All air over brake work, and what is added [kg/kWh]", header, air, left=()),
        table_of(BESIDE_TITLE, ("r/min", *(heading for *_, heading in BESIDE)), beside, left=()),
    ]
