"""Command `apesim gap isolability`."""

from apesim.studies.options import Common, MeasuredFolder, Without


def show_isolability(common: Common, folder: MeasuredFolder, without: Without = None) -> int:
    """Tell which effects the sensors and runs of a folder could show, from which size on, and what would help."""
    from apesim.studies.commands.gap_isolability import isolability_command

    return isolability_command(common, folder=folder, without=without or ())
