"""Keys in which archives were made with another machine than the one of the command line.

Every command of archives takes a machine: it ends with 3 where there are such keys, and writes nothing then.
"""

from collections.abc import Sequence
from pathlib import Path

from apesim.archive import read_about
from apesim.archive.comparison import machine_differences
from apesim.studies.console import INCOMPLETE
from apesim.studies.options import Common


def differences_from_given(common: Common, paths: Sequence[Path]) -> list[dict[str, str]]:
    """Keys in which archives were made with another machine than the one of the command line.

    Parameters
    ----------
    common : Common
        With neither a machine file nor settings, no machine is asked for.
    paths : sequence of path

    Returns
    -------
    list of dict
        ``file``, ``key``, and the texts ``archive`` and ``given``.
    """
    if not common.machine_file and not common.settings:
        return []
    from apesim.quantities.settings import dumps

    given = dumps(common.load_machine())
    return [
        {"file": str(path), "key": row.name, "archive": row.a, "given": row.b}
        for path in paths
        for row in machine_differences(read_about(path)[0], given)
    ]


def difference_lines(differences: list[dict[str, str]]) -> list[str]:
    """A line for each key that differs."""
    return [
        f"{row['file']}: machine: {row['key']} is {row['archive']!r}, given {row['given']!r}" for row in differences
    ]


def refuse_other_machine(common: Common, paths: Sequence[Path]) -> int | None:
    """Tell in which keys archives were made with another machine; the exit code then, None if there are none."""
    differences = differences_from_given(common, paths)
    if not differences:
        return None
    common.console.result({"machine_differences": differences}, *difference_lines(differences))
    return INCOMPLETE
