"""Command `apesim valve fit`."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from apesim.studies.commands.options import Common, MeasuredFolder, Overwrite
from apesim.studies.terminal.console import COMMAND_LINE, DONE, INCOMPLETE

if TYPE_CHECKING:
    from rich.table import Table

    from apesim.studies.identify.estimate import Fit

HEADER = ("run", "largest time shift [ms]", "by noise alone, 95 % [ms]", "left over noise", "limit")
SIGN = "a positive time shift: the measured piston is later than the model's"
ABOVE = "!"
"""Mark of a run that contradicts the model."""


def fit_valve(
    common: Common,
    folder: MeasuredFolder,
    free: Annotated[
        list[str],
        typer.Option(metavar="KEY[=LOW:HIGH]", help="Key of the machine to identify, with bounds. Repeatable."),
    ],
    method: Annotated[
        str, typer.Option(metavar="NAME", help="least-squares, or ga: the paper's genetic algorithm.")
    ] = "least-squares",
    out: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Folder for fit.json, machine.toml and figures.")
    ] = None,
    overwrite: Overwrite = False,
) -> int:
    """Identify parameters from measured lift (Eq. 11), with their uncertainty.

    Runs of the role "fit" are fitted. Those of the role "gate" are not: one that contradicts the fitted model beyond
    noise refuses it (exit code 3; the parameters are reported all the same). Those of the role "check" are reported
    only.
    """
    from dataclasses import replace

    from apesim.quantities import Choice, parse
    from apesim.studies.execution.output import make_folder
    from apesim.studies.execution.own_thread import call_in_thread
    from apesim.studies.identify.estimate import fit
    from apesim.studies.identify.free import METHODS, free_parameters
    from apesim.studies.measured import VALVE, read_measured
    from apesim.studies.measured.lineage import read_parent
    from apesim.valve.bench import run_bench

    console, machine = common.console, common.load_machine()

    # All that can be refused is refused first: method, keys, data and folder, before anything is compiled.
    method = METHODS[parse(method, Choice(METHODS, "command line"), where="--method", file=COMMAND_LINE)]
    free_parameters(machine, free, method)
    measured = read_measured(folder, machine.ambient.pressure, VALVE)
    console.notes(measured.hints)
    if out is not None:
        make_folder(out, overwrite)

    # A first march compiles, so that the time left is that of the fit. The fit has a thread of its own for Ctrl-C.
    console.warm_up(run_bench, machine, 10e-3)
    with console.progress("simulations") as report:
        result = call_in_thread(
            fit, measured, free, machine=machine, method=method, progress=lambda stage, done, total: report(done, total)
        ).result()

    # What is shown, and the files. The parent is read before they are written, as the fitted machine may replace it.
    shown: list[Table | str] = list(_shown(result))
    data = result.to_dict()
    if out is not None:
        result = replace(result, parent_text=read_parent(machine, common.machine_file, common.settings))
        files = result.write(out, overwrite=True)
        data["files"] = [str(path) for path in files]
        shown.append(f"{out}/: {', '.join(path.name for path in files)}")
    console.result(data, *shown)
    for warning in result.warnings:
        console.message(f"warning: {warning}")

    # A gate that the model does not explain refuses it; the parameters have been shown all the same.
    refusing = [run for run in result.gates if run.contradicted]
    for run in refusing:
        console.message(
            f"{run.run}: refuses the model: what is left is {run.residual_over_noise:.3g} times the noise, "
            f"beyond the {run.limit:.3g} that noise and the parameters' uncertainty allow"
        )
    return DONE if result.converged and not refusing else INCOMPLETE


def _shown(result: "Fit") -> "Iterator[Table | str]":
    """Tables and a line for the terminal."""
    from apesim.quantities import unit
    from apesim.studies.measured import CHECK, GATE
    from apesim.studies.terminal.tables import table_of

    # Values in the units of the machine file; not every method gives an interval.
    rows = []
    for key, value in result.parameters.items():
        declared = result.declared[key]
        factor = float(unit(declared.unit).factor)
        texts = ["-" if v is None else f"{v / factor:.6g}" for v in (value, *(result.interval_95[key] or (None, None)))]
        rows.append((key, *texts, f"{declared.unit}{declared.suffix}" or "-"))
    yield table_of("Parameters", ("", "value", "95 % from", "to", "unit"), rows)

    # Runs that were not fitted, by role: a gate may refuse the model, a check is reported only.
    for role, runs in ((GATE, result.gates), (CHECK, result.checks)):
        if runs:
            rows = [
                (
                    run.run,
                    f"{run.time_shift_s * 1e3:+.4g}",
                    f"{run.noise_limit_s * 1e3:.4g}",
                    f"{run.residual_over_noise:.3g}{f' {ABOVE}' if run.contradicted else ''}",
                    f"{run.limit:.3g}",
                )
                for run in runs
            ]
            yield table_of(f"{role.capitalize()} runs, not fitted", HEADER, rows)

    # Sign and mark are explained only where a table has them.
    judged = [*result.gates, *result.checks]
    if judged:
        yield SIGN
    if any(run.contradicted for run in judged):
        yield f"{ABOVE} beyond its limit, what noise and the parameters' uncertainty allow; only a gate refuses"
    yield f"objective {result.objective * 1e3:.5g} mm (Eq. 11); {result.evaluations} simulations"
