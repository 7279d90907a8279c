"""Machines that archives were made with, beside one that is given."""

from collections.abc import Iterable
from os import PathLike, fspath

from apesim.archive import read_about
from apesim.archive.comparison import machine_differences
from apesim.engine.machine import Machine
from apesim.quantities.settings import dumps
from apesim.studies.calls import arguments_of


def differences_from(
    machine: Machine | None, paths: Iterable[str | PathLike[str]], function: str = "differences_from"
) -> list[dict[str, str]]:
    """Find the keys in which archives were made with another machine than a given one.

    Parameters
    ----------
    machine : Machine or None
        None: nothing is compared.
    paths : iterable of path
        Files of the archives.
    function : str
        Name of the function that the machine was given to, for messages.

    Returns
    -------
    list of dict
        ``file``, ``key``, and the values ``archive`` and ``given`` of the key.

    Raises
    ------
    ArchiveError
        An archive cannot be read.
    InputError
        The machine holds what no machine file could say.

    Examples
    --------
    >>> differences_from(None, ["sweep.h5"])
    []
    """
    if machine is None:
        return []
    given = dumps(arguments_of(function, machine)[1])
    return [
        {"file": fspath(path), "key": row.name, "archive": row.a, "given": row.b}
        for path in paths
        for row in machine_differences(read_about(path)[0], given)
    ]
