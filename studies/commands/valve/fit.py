"""Command `apesim valve fit`."""

from typing import Annotated

import typer

from apesim.studies.options import Common, MeasuredFolder


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
    from apesim.studies.commands.fit import fit_command

    return fit_command(common, folder=folder, free=free, method=method)
