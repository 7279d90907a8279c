"""The commands of what measurements show and the model does not."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.options import Common, Jobs, Overwrite, command

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Measured data: a folder with measured.toml.")]
Without = Annotated[
    list[str] | None, typer.Option(metavar="EFFECT", help="Leave an effect of the library out. Repeatable.")
]
gap = typer.Typer(no_args_is_help=True, help="Effects that the model leaves out.")


@command(gap)
def effects(common: Common):
    """The library of effects: slot, parameters with their ranges, equation, source, where it is seen."""
    from apesim.studies.commands.gap import effects_command

    return effects_command(*common)


@command(gap)
def explain(
    common: Common,
    folder: Folder,
    out: Annotated[Path, typer.Option(metavar="OUT", help="Folder for verdict.json, machine.toml and report.html.")],
    without: Without = None,
    tolerance: Annotated[
        float | None, typer.Option(metavar="SIZE", min=0.0, help="A gap below this share of the noise is none; 0.15.")
    ] = None,
    jobs: Jobs = None,
    overwrite: Overwrite = False,
):
    """Find where measurements and model disagree, name the effect that is missing, add it, show the gap shrink."""
    from apesim.studies.commands.gap_explain import explain_command

    return explain_command(*common, folder, out, without or (), tolerance, jobs, overwrite)


@command(gap)
def isolability(common: Common, folder: Folder, without: Without = None):
    """Tell which effects the sensors and runs of a folder could show, from which size on, and what would help."""
    from apesim.studies.commands.gap_isolability import isolability_command

    return isolability_command(*common, folder, without or ())
