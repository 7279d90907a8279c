"""Command `apesim valve fit`."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.options import Common, MeasuredFolder

if TYPE_CHECKING:
    from rich.table import Table

    from apesim.studies.identify.estimate import Fit

HEADER = ("run", "largest time shift [ms]", "by noise alone, 95 % [ms]", "left over noise", "limit")


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
) -> int:
    """Identify parameters from measured lift (Eq. 11), with their uncertainty.

    Runs of the role "fit" are fitted. Those of the role "gate" are not: one that contradicts the fitted model beyond
    noise refuses it (exit code 3; the parameters are told all the same). Those of the role "check" are only reported.
    """
    from apesim.quantities import Choice, parse
    from apesim.studies.execution.own_thread import call_in_thread
    from apesim.studies.identify.estimate import fit
    from apesim.studies.identify.free import METHODS, free_parameters
    from apesim.studies.measured import VALVE, read_measured
    from apesim.valve.bench import run_bench

    console, machine = common.console, common.load_machine()
    method = METHODS[parse(method, Choice(METHODS, "command line"), where="--method", file=COMMAND_LINE)]
    free_parameters(machine, free, method)
    measured = read_measured(folder, machine.ambient.pressure, VALVE)
    console.warm_up(run_bench, machine, 10e-3)
    with console.progress("simulations") as report:
        found = call_in_thread(
            fit, measured, free, machine=machine, method=method, progress=lambda stage, done, total: report(done, total)
        ).result()
    console.result(found.to_dict(), *_shown(found))
    for warning in found.warnings:
        console.message(f"warning: {warning}")
    refusing = [one for one in found.gates if one.contradicted]
    for one in refusing:
        console.message(
            f"{one.run}: refuses the model: what is left is {one.residual_over_noise:.3g} times the noise, "
            f"beyond the {one.limit:.3g} that noise and the parameters' uncertainty allow"
        )
    return DONE if found.converged and not refusing else INCOMPLETE


def _shown(found: "Fit") -> "Iterator[Table | str]":
    """Tables and a line for the terminal."""
    from apesim.quantities import unit
    from apesim.studies.measured import CHECK, GATE
    from apesim.studies.tables import table_of

    rows = []
    for key, value in found.parameters.items():
        declared = found.declared[key]
        factor = float(unit(declared.unit).factor)
        texts = ["-" if v is None else f"{v / factor:.6g}" for v in (value, *(found.interval_95[key] or (None, None)))]
        rows.append((key, *texts, f"{declared.unit}{declared.suffix}" or "-"))
    yield table_of("Parameters", ("", "value", "95 % from", "to", "unit"), rows)
    for role, runs in ((GATE, found.gates), (CHECK, found.checks)):
        if runs:
            rows = [
                (
                    one.run,
                    f"{one.time_shift_s * 1e3:.4g}",
                    f"{one.noise_limit_s * 1e3:.4g}",
                    f"{one.residual_over_noise:.3g}",
                    f"{one.limit:.3g}",
                )
                for one in runs
            ]
            yield table_of(f"{role.capitalize()} runs, not fitted", HEADER, rows)
    yield f"objective {found.objective * 1e3:.5g} mm (Eq. 11); {found.evaluations} simulations"
