"""Command `apesim engine sweep`."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.options import Common, Figures, Jobs, Out, Overwrite, Speeds

ALL_SPEEDS, ALL_TIMINGS, ALL_INTAKES = "300:2400:100 rpm", "both", "epv,cam,ideal"
"""What is swept if nothing else is asked for."""


def sweep_engine(
    common: Common,
    speed: Speeds = ALL_SPEEDS,
    varied: Annotated[
        list[str] | None,
        typer.Option(
            "--vary",
            metavar="KEY=RANGE",
            help='Also over a key of the machine, e.g. supply.pressure="0.6:1.4:0.2 MPa gauge". Repeatable.',
        ),
    ] = None,
    timing: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="Command angles of the epv: fixed (the machine's), corrected (so that it meets its targets), or both.",
        ),
    ] = ALL_TIMINGS,
    intake: Annotated[str, typer.Option(metavar="LIST", help="Of epv, cam, ideal.")] = ALL_INTAKES,
    out: Out = Path("sweep.h5"),
    jobs: Jobs = None,
    dask: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Compute on a cluster: its scheduler, e.g. tcp://HOST:8786.")
    ] = None,
    shard: Annotated[str | None, typer.Option(metavar="i/N", help="Only every N-th point from the i-th.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with an interrupted sweep.")] = False,
    overwrite: Overwrite = False,
    figures: Figures = True,
) -> int:
    """The main job: speeds, intakes, timings and any keys into an archive, figures and a table."""
    import contextlib
    import sys

    from apesim.archive import command_line, read_digest
    from apesim.archive.grid import axes_of
    from apesim.engine.cylinder import INTAKES
    from apesim.quantities import Choice, Culprit, InputError, parse_range
    from apesim.studies.execution.cluster import connected
    from apesim.studies.figures.sweep import sweep_figures
    from apesim.studies.operating_conditions import SPEED
    from apesim.studies.output import written_text
    from apesim.studies.sweep import find_finished, run_sweep, vary
    from apesim.studies.sweep.results import warnings_of
    from apesim.studies.sweep.table import sweep_table
    from apesim.terminal import visible

    console, machine = common.console, common.load_machine()
    speeds = _once(parse_range(speed, SPEED, where="--speed", file=COMMAND_LINE), "--speed", _in_rpm)
    intakes = parse_range(intake, Choice(INTAKES, "command line"), where="--intake", file=COMMAND_LINE)
    _once(intakes, "--intake", INTAKES.__getitem__)
    timings = _timings(timing, intakes)
    variation = vary(varied or (), common.machine_file, common.settings or ())
    shard = _shard(shard)
    if dask and jobs:
        raise InputError([Culprit(COMMAND_LINE, "--jobs", "is for this machine, not for --dask", "leave one out")])
    options = {"timings": timings, "variation": variation, "jobs": jobs, "shard": shard, "resume": resume}
    options |= {"overwrite": overwrite, "warm_up": console.warm_up}
    is_default = (speed, timing, intake) == (ALL_SPEEDS, ALL_TIMINGS, ALL_INTAKES)
    is_default = is_default and not (varied or shard or common.machine_file or common.settings)
    finished = find_finished(out) if resume and is_default and not overwrite else None
    try:
        with contextlib.ExitStack() as stack:
            cluster = stack.enter_context(connected(dask)) if dask else None
            report = stack.enter_context(console.progress("sweep"))
            command = command_line(["apesim", *sys.argv[1:]])
            options |= {"cluster": cluster, "report": report, "command": command}
            result = finished or run_sweep(machine, speeds, intakes, out, **options)
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
    if finished:
        told = f"{told}, made by `{visible(result.archive.provenance.get('command', ''))}`,"
    console.result(data, sweep_table(result.archive), written_text(data, told))
    for line in result.faults + warnings:
        console.message(f"warning: {line}")
    return INCOMPLETE if result.faults and not result.was_finished else DONE


def _in_rpm(speed: float) -> str:
    """A speed [rad/s] as text."""
    from apesim.studies.sweep.plan import rpm

    return f"{rpm(speed):g} r/min"


def _once(values: list, option: str, name: Callable) -> list:
    """The values of an option; `InputError` where one is given twice."""
    from apesim.quantities import Culprit, InputError

    twice = [name(value) for value in dict.fromkeys(values) if values.count(value) > 1]
    if twice:
        raise InputError([Culprit(COMMAND_LINE, option, f"{text} is given twice", "give it once") for text in twice])
    return values


def _timings(text: str, intakes: list[int]) -> tuple[int, ...]:
    """Codes of the timings of an option; `InputError` where there is nothing to correct."""
    from apesim.engine.cylinder import EPV
    from apesim.quantities import Choice, Culprit, InputError, parse
    from apesim.studies.sweep import TIMINGS

    timing = Choice(("fixed", "corrected", "both"), "command line")
    code = parse(text, timing, where="--timing", file=COMMAND_LINE)
    if timing.options[code] == "corrected" and EPV not in intakes:
        wrong = "corrects the commands of an electro-pneumatic valve, but --intake has none"
        raise InputError([Culprit(COMMAND_LINE, "--timing", wrong, 'add epv to --intake, or write "fixed"')])
    return TIMINGS if timing.options[code] == "both" else (TIMINGS[code],)


def _shard(text: str | None) -> tuple[int, int] | None:
    """(i, N) of a text i/N."""
    from apesim.quantities import Culprit, InputError

    if text is None:
        return None
    number, slash, of = text.partition("/")
    if not (slash and number.isdecimal() and of.isdecimal() and 1 <= int(number) <= int(of)):
        raise InputError([Culprit(COMMAND_LINE, "--shard", f"{text!r} is no share of the work", "write e.g. 1/4")])
    return int(number), int(of)
