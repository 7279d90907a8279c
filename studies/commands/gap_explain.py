"""The command of the missing-effect workflow."""

import time
from dataclasses import replace
from pathlib import Path

from apesim.engine.outside_machine import outside_effects_of, switched_on
from apesim.quantities import Fault, InputError
from apesim.quantities.settings import dumps
from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.estimation.residuals import EndedEarly
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.execution.pool import workers_for
from apesim.studies.gap.design.isolability import limit_text
from apesim.studies.gap.input_checks import check_input
from apesim.studies.gap.search.library import faults_of
from apesim.studies.gap.thresholds import TOLERANCE
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
    machine, measured = read_inputs(common, folder, without)
    make_folder(out, overwrite)
    jobs = workers_for(MARCHES * first_march(console, machine, measured), jobs)
    options = {"without": without, "tolerance": TOLERANCE if tolerance is None else tolerance, "jobs": jobs}
    parent_text = parent_of(machine, common.machine_file, common.settings)

    def explained(progress):
        explanation = replace(explain(machine, measured, **options, progress=progress), parent_text=parent_text)
        return explanation, explanation.write(out, overwrite=overwrite, progress=progress)

    try:
        with console.stages("explaining") as progress:
            explanation, data = call_in_thread(explained, progress).result()
    except EndedEarly as error:
        console.message(f"{error}; nothing is concluded")
        return INCOMPLETE
    console.result(data, *shown(data), f"{out}/report.html, machine.toml, verdict.json: {data['wall_time_s']:.1f} s")
    for warning in explanation.warnings:
        console.message(f"warning: {warning}")
    return DONE


def parent_of(machine, machine_file, settings):
    """The machine file that a search begins with, as text: as it stands, where nothing is set besides."""
    return Path(machine_file).read_text(encoding="utf-8") if machine_file and not settings else dumps(machine)


def read_inputs(common, folder, without):
    """Read machine and measured data of a command; what cannot be used is refused before anything is compiled.

    Parameters
    ----------
    common : apesim.studies.options.Common
    folder : path
        Folder of the measured data.
    without : list of str
        Effects that are not to be considered.

    Returns
    -------
    machine : apesim.engine.machine.Machine
    measured : apesim.studies.measured.Measured

    Raises
    ------
    InputError
        With every fault.
    """
    machine = common.load_machine()
    faults = faults_of(without, machine)
    if faults:
        raise InputError([Fault(COMMAND_LINE, f"--{name}", wrong, right) for name, wrong, right in faults])
    measured = read_measured(folder, machine.ambient.pressure)
    check_input(measured)
    return machine, measured


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
        for one in outside_effects_of(machine):
            predict(switched_on(nominal, one), run)

    console.warm_up(march)
    start = time.perf_counter()
    predict(nominal, run)
    return time.perf_counter() - start


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
