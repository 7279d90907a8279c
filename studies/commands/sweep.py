"""Command `apesim engine sweep`."""

import contextlib
import functools
import sys

from apesim.archive import command_line, read_digest
from apesim.archive.grid import axes_of, places_of
from apesim.engine.cylinder import EPV, INTAKES
from apesim.quantities import Choice, Culprit, InputError, parse, parse_range
from apesim.studies.commands.archived import summary
from apesim.studies.commands.given import SPEED
from apesim.studies.commands.machine import load_machine
from apesim.studies.commands.tables import number, table_of, warm_up
from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE

INTAKE = Choice(INTAKES, "command line")
TIMING = Choice(("fixed", "corrected", "both"), "command line")
INCOMPLETE_MARK = "*"
COLUMNS = {"brake_torque_Nm": ("N m", ".2f"), "specific_air_kg_per_kWh": ("kg/kWh", ".1f")}


def sweep_command(
    console, machine_file, settings, speed, varied, timing, intake, out, jobs, dask, shard, resume, overwrite, figures
):
    """A sweep; see `apesim engine sweep --help`.

    Returns
    -------
    int
        Exit code.
    """
    from apesim.studies.execution.cluster import connected
    from apesim.studies.figures.sweep import sweep_figures
    from apesim.studies.sweep import run_sweep, vary
    from apesim.studies.sweep.results import warnings_of

    machine = load_machine(machine_file, settings)
    speeds = _once(parse_range(speed, SPEED, where="--speed", file=COMMAND_LINE), "--speed", _in_rpm)
    intakes = parse_range(intake, INTAKE, where="--intake", file=COMMAND_LINE)
    _once(intakes, "--intake", INTAKES.__getitem__)
    timings = _timings(timing, intakes)
    variation = vary(varied or (), machine_file, settings or ())
    shard = _shard(shard)
    if dask and jobs:
        raise InputError([Culprit(COMMAND_LINE, "--jobs", "is for this machine, not for --dask", "leave one out")])
    options = {"timings": timings, "variation": variation, "jobs": jobs, "shard": shard, "resume": resume}
    options |= {"overwrite": overwrite, "warm_up": functools.partial(warm_up, console)}
    try:
        with contextlib.ExitStack() as stack:
            cluster = stack.enter_context(connected(dask)) if dask else None
            report = stack.enter_context(console.progress("sweep"))
            command = command_line(["apesim", *sys.argv[1:]])
            options |= {"cluster": cluster, "report": report, "command": command}
            result = run_sweep(machine, speeds, intakes, out, **options)
    except KeyboardInterrupt:
        console.message("interrupted; what is done is kept, go on with the same command and --resume")
        raise
    warnings = warnings_of(result.archive)
    drawn = sweep_figures(result.archive, out.with_suffix(".figures")) if figures else []
    data = {
        "archive": str(out),
        "content_sha256": read_digest(out),
        "figures": [str(path) for path in drawn],
        "runs": len(result.archive.runs),
        "axes": axes_of(result.archive),
        "faults": result.faults,
        "warnings": warnings,
        "was_finished": result.was_finished,
        "wall_time_s": result.seconds,
    }
    runs = f"{data['runs']} runs"
    told = f"finished already, its {runs} checked" if result.was_finished else runs
    console.result(data, sweep_table(result.archive), summary(data, told))
    for line in result.faults + warnings:
        console.message(f"warning: {line}")
    return INCOMPLETE if result.faults and not result.was_finished else DONE


def _in_rpm(speed):
    from apesim.studies.sweep.plan import rpm

    return f"{rpm(speed):g} r/min"


def _once(values, option, name):
    """The values of an option; `InputError` where one is given twice."""
    twice = [name(value) for value in dict.fromkeys(values) if values.count(value) > 1]
    if twice:
        raise InputError([Culprit(COMMAND_LINE, option, f"{text} is given twice", "give it once") for text in twice])
    return values


def _timings(text, intakes):
    """Codes of the timings of an option; `InputError` where there is nothing to correct."""
    from apesim.studies.sweep import TIMINGS

    code = parse(text, TIMING, where="--timing", file=COMMAND_LINE)
    if TIMING.options[code] == "corrected" and EPV not in intakes:
        wrong = "corrects the commands of an electro-pneumatic valve, but --intake has none"
        raise InputError([Culprit(COMMAND_LINE, "--timing", wrong, 'add epv to --intake, or write "fixed"')])
    return TIMINGS if TIMING.options[code] == "both" else (TIMINGS[code],)


def _shard(text):
    """(i, N) of a text i/N."""
    if text is None:
        return None
    number, slash, of = text.partition("/")
    if not (slash and number.isdecimal() and of.isdecimal() and 1 <= int(number) <= int(of)):
        raise InputError([Culprit(COMMAND_LINE, "--shard", f"{text!r} is no share of the work", "write e.g. 1/4")])
    return int(number), int(of)


def sweep_table(archive):
    """Brake torque and gross specific air of every actuation over speed and what is varied; what is incomplete marked.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    rich.table.Table
    """
    from apesim.studies.sweep.results import has_incomplete_stroke

    (_, actuations), *axes = axes_of(archive).items()
    incomplete = has_incomplete_stroke(archive)
    blank = " " * int(incomplete.any())
    points = list(zip(*(places.tolist() for places in places_of(archive)), strict=True))
    runs = {point: run for run, point in enumerate(points)}
    shown = sorted({at for at, *_ in points})

    def cell(column, point, form):
        if point not in runs:
            return f"-{blank}"
        mark = INCOMPLETE_MARK if incomplete[runs[point]] else blank
        return number(archive.variables[column].values[runs[point]], form) + mark

    heads, columns = zip(*(head_and_cells(name, texts) for name, texts in axes), strict=True)
    rows = []
    for where in sorted({tuple(where) for _, *where in points}):
        row = [columns[axis][at] for axis, at in enumerate(where)]
        row += [cell(column, (at, *where), form) for column, (_, form) in COLUMNS.items() for at in shown]
        rows.append(row)
    header = list(heads)
    header += [f"{actuations[at]}\n[{unit}]" for unit, _ in COLUMNS.values() for at in shown]
    title = "Brake torque, and all air over brake work"
    if incomplete.any():
        title += f" ({INCOMPLETE_MARK} incomplete stroke of the valve)"
    return table_of(title, header, rows, left=range(len(axes) - 1))


def head_and_cells(name, texts):
    """Head and cells of a column of texts: a unit that all share stands in the head."""
    from apesim.studies.sweep.plan import in_one_unit

    cells, unit = in_one_unit(texts)
    name = name.removesuffix("_rpm").replace("_", " ")  # breaks at spaces only
    return f"{name}\n[{unit}]" if unit else name, cells
