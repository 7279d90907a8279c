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

    Parameters
    ----------
    machine : Machine
        Machine of the file and the settings.
    machine_file : path or None
        File of the option ``--machine``; None: the embedded machine.
    settings : sequence of str or None
        Options ``--set``, each ``key=value``.

    Returns
    -------
    str
        TOML: the file with its comments; written anew where something was set, or there is no file.

    Examples
    --------
    >>> machine = Machine().with_(engine_bore="90 mm")
    >>> lines = read_parent(machine, None, ["engine.bore=90 mm"]).splitlines()
    >>> next(line for line in lines if line.startswith("bore"))
    'bore = "90 mm" # 5 to 1000 mm; chosen'
    """
    return Path(machine_file).read_text(encoding="utf-8") if machine_file and not settings else dumps(machine)


def find_lineage(measured: Measured, parent_text: str, machine: Machine) -> dict[str, str]:
    """Digests of what a verdict comes from.

    Parameters
    ----------
    measured : apesim.studies.measured.Measured
    parent_text : str
        The machine file that the search began with.
    machine : Machine
        Machine that the file describes, with its effects from outside.

    Returns
    -------
    dict of str
        SHA-256 by ``parent_machine_sha256``, ``measured_data_sha256`` and one key for each effect from outside.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from apesim.studies.gap.example_bench import write_example
    >>> from apesim.studies.measured import read_measured
    >>> with TemporaryDirectory() as folder:
    ...     write_example(Path(folder))
    ...     lineage = find_lineage(read_measured(folder), dumps(Machine()), Machine())
    >>> {name: len(digest) for name, digest in lineage.items()}
    {'parent_machine_sha256': 64, 'measured_data_sha256': 64}
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
