"""The command of the missing-effect workflow."""

import json
import time
from pathlib import Path

from apesim.archive import ArchiveError, replace_file
from apesim.engine.effects import ALL_EFFECTS
from apesim.quantities import Culprit, InputError
from apesim.quantities.settings import dumps
from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE, plain
from apesim.studies.estimation.residuals import EndedEarly
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.execution.pool import Team, workers_for
from apesim.studies.gap.decide.verdict import TOLERANCE
from apesim.studies.gap.design.next_test import next_test
from apesim.studies.gap.input_checks import gate
from apesim.studies.gap.report.extended_machine import child_of, lineage_of
from apesim.studies.gap.report.petab_select import model_space
from apesim.studies.gap.report.verdict_json import record
from apesim.studies.gap.tables.latent import branches
from apesim.studies.gap.work import Work
from apesim.studies.gap.workflow import explain
from apesim.studies.measured import read_measured
from apesim.studies.measured.prediction import predict, run_of, with_value
from apesim.studies.output import make_folder
from apesim.studies.tables import table_of

MARCHES = 4000
"""That a search takes, or more."""


def explain_command(common, *, folder, out, without, tolerance, jobs, overwrite):
    """Name what is missing between a machine and measured data; see `apesim gap explain --help`.

    Parameters
    ----------
    common : apesim.studies.options.Common
    folder : path
        Of the measured data.
    out : path
        Folder to write.
    without : list of str
        Effects that are not to be considered.
    tolerance : float or None
        Size of a gap, over the noise, that does not matter; None: `TOLERANCE`.
    jobs : int or None
        Processes; None: as many as the work is worth.
    overwrite : bool
        Write into a folder that holds something.

    Returns
    -------
    int
        Exit code.
    """
    console = common.console
    machine, measured, _ = given(common, folder, without)
    make_folder(out, overwrite)
    parent = parent_of(machine, common.machine_file, common.settings)
    jobs = workers_for(MARCHES * first_march(console, machine, measured), jobs)
    start = time.perf_counter()
    try:
        with console.stages("explaining") as report, Team(jobs) as team:
            options = {"without": without, "tolerance": TOLERANCE if tolerance is None else tolerance}
            work = Work(team, report)
            findings, told = call_in_thread(_found, machine, measured, parent, out, work, options).result()
    except EndedEarly as error:
        console.message(f"{error}; nothing is concluded")
        return INCOMPLETE
    data = told | {"wall_time_s": time.perf_counter() - start}
    _write(out, "verdict.json", json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    (Path(out) / "petab_select").mkdir(exist_ok=True)
    for name, text in model_space(findings).items():
        _write(out, f"petab_select/{name}", text)
    console.result(data, *shown(data), f"{out}/report.html, machine.toml, verdict.json: {data['wall_time_s']:.1f} s")
    for warning in findings.warnings:
        console.message(f"warning: {warning}")
    return DONE


def parent_of(machine, machine_file, settings):
    """The machine file that a search begins with, as text: as it stands, where nothing is set besides."""
    return Path(machine_file).read_text(encoding="utf-8") if machine_file and not settings else dumps(machine)


def given(common, folder, without):
    """What a command of the missing effect is given, checked.

    Returns
    -------
    machine : apesim.engine.machine.Machine
    measured : apesim.studies.measured.Measured
    warnings : list of str
        See `apesim.studies.gap.input_checks.gate`.

    Raises
    ------
    InputError
    """
    machine = common.load_machine()
    check_names(without)
    measured = read_measured(folder, machine.ambient.pressure)
    return machine, measured, gate(measured)


def first_march(console, machine, measured):
    """Simulate a run, as it is, with an effect and with a table, so that what is timed after it is compiled.

    Returns
    -------
    float
        Time that a run takes then [s].
    """
    run = measured.runs[0]
    nominal = run_of(machine, run)

    def march():
        predict(nominal, run)
        for key in ("effects.side_force.force", "effects.tabulated_force.force_at_50"):
            predict(with_value(nominal, key, 1.0), run)

    console.warm_up(march)
    start = time.perf_counter()
    predict(nominal, run)
    return time.perf_counter() - start


def check_names(names):
    """Raise `InputError` where one is no effect."""
    known = [effect.name for effect in ALL_EFFECTS]
    wrong = [name for name in names if name not in known]
    if wrong:
        raise InputError(
            [Culprit(COMMAND_LINE, "--without", f"{name!r} is no effect", "see apesim gap effects") for name in wrong]
        )


def _found(machine, measured, parent, out, work, options):
    """The findings as they are, and as plain data; the child and the report are written."""
    from apesim.studies.figures.gap import draw_gap
    from apesim.studies.gap.report.comparison import compare
    from apesim.studies.gap.report.html import added_to, page, tried

    findings = explain(machine, measured, work=work, **options)
    work.tell("writing the report", 0, 1)
    data = plain(record(findings) | {"next_test": next_test(findings)}) | {"lineage": lineage_of(measured, parent)}
    _write(out, "machine.toml", child_of(findings, data))
    compared = compare(findings)
    (Path(out) / "figures").mkdir(exist_ok=True)
    latent = branches(findings.tabulated.model) if findings.tabulated else ()
    ambient = machine.ambient.pressure
    figures = draw_gap(compared, tried(findings), added_to(findings), ambient, Path(out) / "figures", latent)
    _write(out, "report.html", page(findings, data, compared, figures))
    return findings, data


def _write(out, name, text):
    """Write a file, complete or not at all."""
    path = Path(out) / name
    try:
        replace_file(path, text.encode())
    except OSError as error:
        raise ArchiveError(path, f"cannot be written: {error.strerror}", "choose another --out") from None


def shown(data):
    """The verdict on a terminal."""
    yield f"{data['verdict']}: {data['sentence']} ({data['reason']})"
    rows = [
        [row["effect"], f"{row['deviations']:.1f}", limit_text(data["detection_limits"].get(row["effect"]))]
        for row in data["scores"][:8]
    ]
    yield f"Next test: {data['next_test']['text']}"
    if rows:
        yield table_of("", ("effect", "score [deviations]", "visible from (5 deviations)"), rows, left=(0,))


def limit_text(limit):
    """From which size on an effect is seen."""
    if limit is None or limit["limit"] is None:
        return "beyond its range"
    return f"{limit['limit']:.3g} {limit['unit']}".strip()
