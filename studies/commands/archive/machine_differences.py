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
    """Find keys in which archives were made with another machine than the one of the command line.

    Parameters
    ----------
    common : Common
        With neither a machine file nor settings, no machine is asked for.
    paths : sequence of path
        Archives.

    Returns
    -------
    list of dict
        ``file``, ``key``, and the texts ``archive`` and ``given``.

    Raises
    ------
    InputError
        The machine of the command line cannot be used.

    Examples
    --------
    >>> import tempfile
    >>> from apesim.archive import Archive, write
    >>> from apesim.archive.columns import run_axis
    >>> from apesim.engine.machine import Machine
    >>> from apesim.studies.console import Console
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "a.h5"
    ...     _ = write(Archive(Machine().to_toml(), {}, {"run": run_axis(1)}), path)
    ...     differences = differences_from_given(Common(Console(), settings=["engine.bore=90 mm"]), [path])
    >>> [(row["key"], row["archive"], row["given"]) for row in differences]
    [('engine.bore', '85 mm', '90 mm')]
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
    """Write a line for each key that differs.

    Parameters
    ----------
    differences : list of dict
        Keys, see `differences_from_given`.

    Returns
    -------
    list of str
        Lines for the terminal.

    Examples
    --------
    >>> difference_lines([{"file": "a.h5", "key": "engine.bore", "archive": "85 mm", "given": "90 mm"}])
    ["a.h5: machine: engine.bore is '85 mm', given '90 mm'"]
    """
    return [
        f"{row['file']}: machine: {row['key']} is {row['archive']!r}, given {row['given']!r}" for row in differences
    ]


def refuse_other_machine(common: Common, paths: Sequence[Path]) -> int | None:
    """Show in which keys archives were made with another machine than the one of the command line.

    Parameters
    ----------
    common : Common
        Console, and the machine of the command line.
    paths : sequence of path
        Archives.

    Returns
    -------
    int or None
        Exit code 3 where there are such keys, which are shown then; None where there are none.

    Raises
    ------
    InputError
        The machine of the command line cannot be used.

    Examples
    --------
    Without a machine on the command line nothing is compared:

    >>> from apesim.studies.console import Console
    >>> refuse_other_machine(Common(Console()), [Path("a.h5")]) is None
    True
    """
    differences = differences_from_given(common, paths)
    if not differences:
        return None
    common.console.result({"machine_differences": differences}, *difference_lines(differences))
    return INCOMPLETE
