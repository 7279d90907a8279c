"""Lineage of a machine file that measured data led to: the file it began with, and digests of what it comes from."""

import hashlib
from collections.abc import Sequence
from os import PathLike
from pathlib import Path

from apesim.archive import sha256
from apesim.engine.machine import Machine
from apesim.engine.outside_machine import outside_effects_of
from apesim.quantities.settings import dumps
from apesim.studies.measured import Measured
from apesim.studies.measured.sensors import FILE

HASHED_BYTES = 1 << 22
"""Bytes that are hashed at once, as a data file may be longer than the free memory."""


def read_parent(machine: Machine, machine_file: str | PathLike[str] | None, settings: Sequence[str] | None) -> str:
    """Read the machine file that a search begins with, as text: as it stands, where nothing is set besides.

    It is TOML with the file's comments; written anew from `machine` where `settings`, each ``key=value`` of ``--set``,
    are given, or where there is no file (None: the embedded machine).
    """
    return Path(machine_file).read_text(encoding="utf-8") if machine_file and not settings else dumps(machine)


def find_lineage(measured: Measured, parent_text: str, machine: Machine) -> dict[str, str]:
    """Digests of what a verdict comes from, each a SHA-256 by its key.

    The keys are ``parent_machine_sha256``, of the machine file `parent_text` that the search began with,
    ``measured_data_sha256`` and one for each effect from outside of `machine`, which that file describes.
    """
    files = {f"effect_{outside.name}_sha256": outside.sha256 for outside in outside_effects_of(machine)}
    return {"parent_machine_sha256": sha256(parent_text), "measured_data_sha256": _hash_data(measured)} | files


def _hash_data(measured: Measured) -> str:
    """Digest of a folder's measured.toml and of the data files that it names, in their order."""
    folder = Path(measured.folder)
    names = [FILE, *(run.data for run in measured.runs if run.data)]
    return sha256("".join(_hash_file(folder / name) for name in names))


def _hash_file(path: Path) -> str:
    """Digest of a text in any encoding, whatever ends its lines."""
    with path.open("rb") as file:
        digest = hashlib.sha256()
        held = b""
        while data := file.read(HASHED_BYTES):
            data = held + data
            held = b"\r" if data.endswith(b"\r") else b""
            digest.update(data.removesuffix(b"\r").replace(b"\r\n", b"\n").replace(b"\r", b"\n"))
        digest.update(held.replace(b"\r", b"\n"))
    return digest.hexdigest()
