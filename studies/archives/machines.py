"""Machines that archives were made with: read from their texts, and beside one that is given."""

from collections.abc import Iterable
from os import PathLike, fspath
from typing import Any

from apesim.archive import read_about
from apesim.archive.comparison import machine_differences
from apesim.engine.effects import Effects
from apesim.engine.machine import Machine
from apesim.quantities import Curve, Fault, InputError
from apesim.quantities.settings import dumps, read, schema
from apesim.quantities.toml_text import parse_toml
from apesim.studies.execution.calls import arguments_of

WHERE = "machine of the archive"
"""What faults in the text of an archive's machine name as their file."""


def differences_from(
    machine: Machine | None, paths: Iterable[str | PathLike[str]], function: str = "differences_from"
) -> list[dict[str, str]]:
    """Find the keys in which archives were made with another machine than a given one.

    Each difference has ``file``, ``key`` and the values ``archive`` and ``given``; with None nothing is compared.
    `function` is the name that messages give; raises ArchiveError where an archive cannot be read, InputError where the
    machine holds what no machine file could say.
    """
    if machine is None:
        return []
    given = dumps(arguments_of(function, machine)[1])
    return [
        {"file": fspath(path), "key": row.name, "archive": row.a, "given": row.b}
        for path in paths
        for row in machine_differences(read_about(path)[0], given)
    ]


def read_recorded_machine(text: str) -> Machine:
    r"""Read the machine of an archive from its TOML text, without effects from outside: an archive makes no code run.

    Raises InputError where the text is none of a machine, or names a file: what is in an archive opens none.
    """
    data = parse_toml(WHERE, text, 'bore = "85 mm"')
    effects = data.get("effects")
    if isinstance(effects, dict):
        data["effects"] = {name: table for name, table in effects.items() if name in Effects._fields}
    curves = [leaf.key for leaf in schema(Machine) if isinstance(leaf.declaration, Curve)]
    named = [key for key in curves if _names_file(data, key)]
    named += _find_files_of_cylinders(data.get("cylinder"))
    if named:
        raise InputError([Fault(WHERE, key, "names a file", "write the curve itself") for key in named])
    return read(Machine, data, WHERE)


def _find_files_of_cylinders(tables: Any) -> list[str]:
    """Keys of tables ``[[cylinder]]`` that hold a text where a curve is due."""
    own: Any = {leaf.key: leaf.declaration for leaf in schema(Machine)}["cylinder"]
    return [
        f"cylinder[{number}].{key}"
        for number, table in enumerate(tables if isinstance(tables, list) else [], 1)
        for key, raw in (own.flatten(table) if isinstance(table, dict) else ())
        if isinstance(own.declared(key), Curve) and isinstance(raw, str) and raw
    ]


def _names_file(data: Any, key: str) -> bool:
    """Whether a key of nested tables holds a text that is not empty."""
    for name in key.split("."):
        data = data.get(name) if isinstance(data, dict) else None
    return isinstance(data, str) and bool(data)
