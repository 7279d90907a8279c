"""Command `apesim new`."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from apesim.studies.commands.options import Common, FigureFile, Overwrite, as_options
from apesim.studies.terminal.console import COMMAND_LINE

if TYPE_CHECKING:
    from apesim.engine.machine import Machine


def make_machine_file(
    common: Common,
    out: Annotated[
        Path | None, typer.Argument(metavar="FILE.toml", help="Machine file to write; it is printed if left out.")
    ] = None,
    answer: Annotated[
        list[str] | None,
        typer.Option("--answer", metavar="NAME=VALUE", help='An answer, e.g. bore="60 mm". Repeatable.'),
    ] = None,
    default: Annotated[
        bool, typer.Option("--default", help="Ask nothing: what is not answered follows, or is the default's.")
    ] = False,
    figure: FigureFile = None,
    overwrite: Overwrite = False,
) -> None:
    """Make the file of a machine of one's own from fifteen answers; the rest follows by stated rules.

    On a terminal it asks, and Enter takes what is shown. What is answered by --answer, or by a key of --machine and
    --set that is not the default machine's, is not asked for. It warns of what is implausible.

    Examples
    --------
    >>> from typer.testing import CliRunner
    >>> from apesim.studies.commands.cli import app
    >>> text = CliRunner().invoke(app, ["new", "--default", "--answer", "bore=60 mm", "--quiet"]).stdout
    >>> next(line.split("#")[0].strip() for line in text.splitlines() if line.startswith("bore"))
    'bore = "60 mm"'
    """
    from apesim.studies.design.machine_design import design_machine
    from apesim.studies.drawing.files import check_ending
    from apesim.studies.drawing.machine import write_machine_figure
    from apesim.studies.execution.output import refuse_to_replace

    # What cannot be written is refused before anything is asked.
    console, machine = common.console, common.load_machine()
    for path in (out, figure):
        if path is not None:
            refuse_to_replace(path, overwrite=overwrite)

    if figure is not None:
        check_ending(figure)

    # The answers: those of the command line, then those of the terminal.
    answers = _read_answers(answer or ())
    if not default:
        answers = _ask(machine, answers)
    options = {name: f"--answer {name}" for name in (*answers, "vessel_volume")}
    with as_options("design_machine", **options):
        design = design_machine(machine, **answers)

    # Files come last, so that nothing is left half done.
    if out is not None:
        design.write(out, overwrite=overwrite)
    if figure is not None:
        write_machine_figure(design.machine, figure, overwrite=overwrite)
    data = {"file": out and str(out), "figure": figure and str(figure)} | design.to_dict()
    told = [f"{path}: written" for path in (out, figure) if path is not None]
    console.result(data, *(told if out is not None else [design.to_toml().rstrip()]))
    for text in design.warnings:
        console.message(f"warning: {text}")
    if out is not None:
        speed = f"{data['rated_speed_rpm']:g} rpm"
        console.message(f'next: apesim engine run --speed "{speed}" --machine {out}')


def _read_answers(texts: Sequence[str]) -> dict[str, Any]:
    """Answers of the command line, by name."""
    from apesim.quantities import Fault, InputError
    from apesim.studies.design.questions import DISCHARGE, find_wrong_name

    answers: dict[str, Any] = {}
    faults = []
    for text in texts:
        name, sign, value = (part.strip() for part in text.partition("="))
        fault = find_wrong_name(name)
        if not sign or not value:
            faults.append(Fault(COMMAND_LINE, "--answer", f"{text!r} is no answer", 'write e.g. bore="60 mm"'))
        elif fault:
            faults.append(Fault(COMMAND_LINE, f"--answer {name}", *fault))
        elif name == DISCHARGE[0].name:
            answers[name] = [*answers.get(name, []), value]
        else:
            answers[name] = value
    if faults:
        raise InputError(faults)
    return answers


def _ask(machine: "Machine", answers: Mapping[str, Any]) -> dict[str, Any]:
    """Ask on the terminal for what is not answered; without one, say which answers are missing."""
    from apesim.quantities import Fault, InputError
    from apesim.studies.design.dialogue import ask_all, find_open

    missing = [each for each in find_open(machine, answers) if each.name != "discharge_test"]
    if not missing:
        return dict(answers)
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        wrong = f"there is no terminal to ask on, and {', '.join(each.name for each in missing)} are not answered"
        raise InputError([Fault(COMMAND_LINE, "", wrong, "give each as --answer NAME=VALUE, or --default")])

    def ask(prompt: str) -> str:
        print(prompt, end="", file=sys.stderr, flush=True)
        line = sys.stdin.readline()
        if not line:
            raise EOFError
        return line

    try:
        return ask_all(machine, answers, ask, lambda line: print(line, file=sys.stderr))
    except EOFError:
        print(file=sys.stderr)
        wrong = "the answers ended before the last question; nothing was written"
        raise InputError([Fault(COMMAND_LINE, "", wrong, "answer all, or give --default for the rest")]) from None
