"""Results of operating points as an archive, and what is reported of those that failed."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import nan
from typing import Any

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.columns import NO_YES, column, meanings_of
from apesim.archive.grid import axes_of, places_of
from apesim.engine.angles import DEGREE
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cylinder import INTAKES
from apesim.engine.drivetrain.indicators import OWN_INDICATORS, SHAFT_INDICATORS
from apesim.engine.drivetrain.preparing import count_cylinders
from apesim.engine.indicators import COUNTS, FLAGS, INDICATORS
from apesim.engine.warnings import EngineWarning
from apesim.march.adaptive import Status
from apesim.quantities import split_header
from apesim.studies.run.engine_run import TRACE_NAMES
from apesim.studies.run.march_status import STATUS_MEANINGS
from apesim.studies.sweep.compute import ANGLE_STEP, LIFT, NOT_ASKED, NOT_JUDGED, NOT_MARCHED, WARNING_FLAGS
from apesim.studies.sweep.plan import ACTUATIONS, TIMING_NAMES, Point, actuation_of
from apesim.studies.sweep.variation import Variation, varied_columns
from apesim.studies.timing import Reason

REASON_MEANINGS = ", ".join(f"{int(reason)} {reason.name.lower().replace('_', ' ')}" for reason in Reason)
CODES = {
    "actuation": ("what moves the intake, and whether its commands are corrected", list(ACTUATIONS)),
    "intake": ("what opens the intake", INTAKES),
    "timing": ("command angles: fixed by the machine, or corrected so that the valve meets its targets", TIMING_NAMES),
}
COMMANDS = {
    "energise_deg": "command angle of the energising, as used",
    "release_deg": "command angle of the release, as used",
}


def archive_of(
    points: Sequence[Point],
    results: Sequence[tuple[Mapping[str, Any], np.ndarray | None]],
    variation: Variation,
    machine: str,
    provenance: dict[str, str],
) -> Archive:
    """Store the results of some operating points of a sweep, at least one, as an archive with a run for each.

    `results` are those of `apesim.studies.sweep.compute.compute`, with a trace of each point or of none; `machine` is
    the TOML text before anything is varied; traces are stored over crank angle [deg].
    """
    scalars = [scalars for scalars, _ in results]
    traces = [trace for _, trace in results if trace is not None]
    variables = {"run": column([point.run for point in points], "1", "number of the run")}
    if traces:
        angles = points[0].trace_start / DEGREE + ANGLE_STEP / DEGREE * np.arange(len(traces[0]))
        variables["crank_angle"] = Variable(("crank_angle",), angles, "deg", "crank angle after TDC")
    variables |= _what_was_run(points) | varied_columns(variation, [point.combination for point in points])
    variables |= _how_it_ended(scalars) | _indicators(scalars) | _warnings(scalars)
    if traces:
        variables |= _traces(traces)
    variables |= _cylinders(max(map(count_cylinders, variation.machines)), scalars, traces)
    axes = "actuation", *(axis.name for axis in variation.axes), "speed_rpm"
    variables |= {name: replace(variables[name], coordinate=True) for name in axes}
    return Archive(machine, provenance, variables)


def _traces(traces: Sequence[np.ndarray]) -> dict[str, Variable]:
    """Traces of each point, a variable for each of their columns."""
    columns = np.empty((len(TRACE), len(traces), len(traces[0])))
    for place, trace in enumerate(traces):
        columns[:, place] = trace.T
    variables = {}
    for header, values in zip(TRACE, columns, strict=True):
        name, unit = split_header(header)
        variables[name] = Variable(("run", "crank_angle"), values, unit, TRACE_NAMES[name])  # type: ignore[arg-type]
    return variables


def _what_was_run(points: Sequence[Point]) -> dict[str, Variable]:
    """Codes of the actuation, the intake and the timing of each point."""
    codes = {
        "actuation": [actuation_of(point) for point in points],
        "intake": [point.machine.engine.intake for point in points],
        "timing": [point.timing for point in points],
    }
    return {
        name: column(codes[name], "1", description, meanings_of(names)) for name, (description, names) in CODES.items()
    }


def _how_it_ended(scalars: Sequence[Mapping[str, Any]]) -> dict[str, Variable]:
    """Status, reason of the timing and command angles [deg] of each point."""
    texts_by_name = {
        "status": ("how the march ended", f"{NOT_MARCHED} not marched, {STATUS_MEANINGS}"),
        "timing_reason": (
            "whether the corrected timing is in reach, and if not, why",
            f"{NOT_ASKED} not asked for, {REASON_MEANINGS}",
        ),
    }
    variables = {
        name: column([values[name] for values in scalars], "1", *texts) for name, texts in texts_by_name.items()
    }
    for name, description in COMMANDS.items():
        variables[name] = column(np.array([values[name] for values in scalars], float), "deg", description)
    return variables


def _indicators(scalars: Sequence[Mapping[str, Any]]) -> dict[str, Variable]:
    """Indicators of each point, see `apesim.engine.indicators.INDICATORS`."""
    variables = {}
    for name, (unit, description) in INDICATORS.items():
        values = np.array([values[name] for values in scalars], dtype=float)
        if name in FLAGS or name in COUNTS:
            values = np.nan_to_num(values).astype(np.int64)
        variables[name] = column(values, unit, description, NO_YES if name in FLAGS else "")
    return variables


def _cylinders(count: int, scalars: Sequence[Mapping[str, Any]], traces: Sequence[np.ndarray]) -> dict[str, Variable]:
    """What each of several cylinders does, NaN where a run has fewer; nothing where all machines of a sweep have one.

    `count` is that of the machine with most: parts of a sweep have the same variables, whatever runs they hold.
    """
    if count < 2:
        return {}
    dims, text = ("run", "cylinder"), "of each cylinder"
    variables = {"cylinder": Variable(("cylinder",), np.arange(1, count + 1), "1", "number of the cylinder")}
    for name, (unit, description) in SHAFT_INDICATORS.items():
        found = np.array([values.get(name, nan) for values in scalars], dtype=float)
        variables[name] = column(found, unit, description)
    declared = {name: INDICATORS[name] for name in OWN_INDICATORS}
    declared |= {name: ("deg", description) for name, description in COMMANDS.items()}
    for name, (unit, description) in declared.items():
        found = np.full((len(scalars), count), nan)
        for run, values in enumerate(scalars):
            found[run, : len(values["cylinders"])] = [own[name] for own in values["cylinders"]]
        short = name.replace("cylinder_", "")
        variables[f"cylinder_{short}"] = Variable(dims, found, unit, f"{description}, {text}")
    if traces:
        lifts = np.full((len(scalars), count, len(traces[0])), nan)
        for run, (values, trace) in enumerate(zip(scalars, traces, strict=True)):
            lifts[run, 0] = trace[:, LIFT]
            for number, lift in enumerate(values["other_lifts"], 1):
                lifts[run, number] = lift
        description = f"lift of the intake, {text}, over the angle of the shaft"
        variables["cylinder_lift"] = Variable((*dims, "crank_angle"), lifts, "m", description)
    return variables


def _warnings(scalars: Sequence[Mapping[str, Any]]) -> dict[str, Variable]:
    """How many warnings a run has, and a flag for each kind: words that select in a table, where bits would not."""
    description = f"number of warnings, each with a flag below; {NOT_JUDGED}: no results to judge"
    variables = {"warnings": column(np.array([values["warnings"] for values in scalars], int), "1", description)}
    for warning, flag in WARNING_FLAGS.items():
        values = [scalar[flag] for scalar in scalars]
        variables[flag] = column(values, "1", warning.summary, f"{NOT_JUDGED} not judged, {NO_YES}")
    return variables


def flagged(archive: Archive, warning: EngineWarning) -> np.ndarray:
    """Find the runs of a sweep that have a given warning, as a (runs,) mask; False where a run has no results."""
    return archive.variables[WARNING_FLAGS[warning]].values == 1


def has_incomplete_stroke(archive: Archive) -> np.ndarray:
    """Find the runs of a sweep whose valve does not open fully and close fully in every cycle, as a (runs,) mask.

    >>> columns = {flag: column([False, False], "1", flag) for flag in WARNING_FLAGS.values()}
    >>> columns["warning_opens_partly"] = column([False, True], "1", EngineWarning.OPENS_PARTLY.summary)
    >>> has_incomplete_stroke(Archive("", {}, columns)).tolist()
    [False, True]
    """
    return np.any([flagged(archive, warning) for warning in WARNING_FLAGS if warning.is_incomplete_stroke], axis=0)


def warnings_of(archive: Archive) -> list[str]:
    """Write one line for each kind of warning that runs of a sweep have.

    It says what is wrong, in how many runs, in which first, and the flag to look for in the archive.
    """
    lines, names = [], names_of(archive)
    for warning, flag in WARNING_FLAGS.items():
        runs = np.flatnonzero(flagged(archive, warning))
        if len(runs):
            count = f"{len(runs)} of {len(names)} runs"
            first = f"run {archive.runs[runs[0]]} ({names[runs[0]]})"
            lines.append(f"{warning.summary}: {count}, the first is {first}; in the archive: {flag}")
    return lines


def names_of(archive: Archive) -> list[str]:
    """Name each run of a sweep in words: "epv corrected, supply_pressure 1 MPa gauge, 600 r/min"."""
    columns = []
    for (name, texts), places in zip(axes_of(archive).items(), places_of(archive), strict=True):
        before = "" if name in ("actuation", "speed_rpm") else f"{name} "
        columns.append([before + texts[place] for place in places])
    return [", ".join(words) for words in zip(*columns, strict=True)]


def faults_of(archive: Archive) -> list[str]:
    """Write one line for each point that is out of reach, failed or did not reach a periodic state.

    It names the run, says what is wrong, and gives a remedy where there is one.
    """
    v = {name: archive.variables[name].values for name in ("run", "timing_reason", "status", "converged", "cycles")}
    lines = []
    for what, run, reason, status, converged, cycles in zip(names_of(archive), *v.values(), strict=True):
        name = f"run {run} ({what})"
        if reason > 0:
            lines.append(f"{name}: corrected timing out of reach: {Reason(reason).remedy}")
        elif status != Status.DONE:
            lines.append(f"{name}: failed: {Status(status).remedy}")
        elif not converged:
            lines.append(f"{name}: not periodic after {cycles} cycles; its state still changes")
    return lines
