"""The commands of what measurements show and the model does not."""

import typer

from studies.options import Common, command

gap = typer.Typer(no_args_is_help=True, help="Effects that the model leaves out.")


@command(gap)
def effects(common: Common):
    """The library of effects: slot, parameters with their ranges, equation, source, where it is seen."""
    from studies.commands.gap import effects_command

    return effects_command(*common)
