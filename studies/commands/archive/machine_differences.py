"""Keys in which archives were made with another machine than the one of the command line.

Every command of archives takes a machine: it ends with 3 where there are such keys, and writes nothing then.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from apesim.studies.commands.options import Common
from apesim.studies.terminal.console import INCOMPLETE

if TYPE_CHECKING:
    from apesim.engine.machine import Machine


def given_machine(common: Common) -> "Machine | None":
    """Return the machine of the command line; None with neither a machine file nor settings.

    Raises InputError where the machine cannot be used.

    Examples
    --------
    >>> from apesim.studies.terminal.console import Console
    >>> given_machine(Common(Console(), settings=["engine.bore=90 mm"])).engine.bore
    0.09
    >>> given_machine(Common(Console())) is None
    True
    """
    return common.load_machine() if common.machine_file or common.settings else None


def difference_lines(differences: Sequence[dict[str, str]]) -> list[str]:
    """Write a line for the terminal for each key that differs, as `differences_from` gives them."""
    return [
        f"{row['file']}: machine: {row['key']} is {row['archive']!r}, given {row['given']!r}" for row in differences
    ]


def refuse_other_machine(common: Common, paths: Sequence[Path]) -> int | None:
    """Show in which keys archives were made with another machine than the one of the command line.

    Returns exit code 3 where there are such keys; None where there are none, or no machine is given. Raises InputError
    where the machine of the command line cannot be used.
    """
    from apesim.studies.archives.machines import differences_from

    differences = differences_from(given_machine(common), paths)
    if not differences:
        return None
    common.console.result({"machine_differences": differences}, *difference_lines(differences))
    return INCOMPLETE
