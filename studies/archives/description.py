"""Descriptions of archives: what they hold and where it comes from, and whether the file is whole."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from typing import TYPE_CHECKING, Any, ClassVar

from apesim.archive import read_digest
from apesim.archive.inspection import info, verify
from apesim.engine.machine import Machine
from apesim.results import Result, Scalar, needed
from apesim.studies.archives.machines import differences_from
from apesim.studies.archives.result_kinds import kind_of
from apesim.studies.execution.calls import arguments_of, public

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, eq=False, repr=False)
class ArchiveDescription(Result):
    """What an archive holds and where it comes from.

    Attributes
    ----------
    contents : dict
        See `apesim.archive.inspection.info`: format, axes, variables, machine, provenance, missing runs; and the kind.
    machine_differences : sequence of dict
        Keys in which it was made with another machine than the one that was given.
    """

    title: ClassVar[str] = "archive"

    contents: dict[str, Any] = field(kw_only=True)
    machine_differences: Sequence[dict[str, str]] = field(default=(), kw_only=True)

    @property
    def is_whole(self) -> bool:
        """Whether no planned run is missing."""
        return self.contents["runs_planned"] is None or not self.contents["missing_runs"]

    def to_dict(self) -> dict[str, Any]:
        """Return the content of ``apesim archive info --json``.

        Returns
        -------
        dict

        Examples
        --------
        >>> contents = {"runs": 2, "runs_planned": 2, "missing_runs": []}
        >>> ArchiveDescription({}, contents=contents).to_dict()["machine_differences"]
        []
        """
        return self.contents | {"machine_differences": list(self.machine_differences)}

    def to_pandas(self) -> "pandas.DataFrame":
        """Make a table of the variables: one row each, with axes, unit and meaning.

        Returns
        -------
        pandas.DataFrame
            Index: name of the variable.

        Raises
        ------
        ImportError
            pandas is not installed.

        Examples
        --------
        >>> torque = {"name": "torque", "dims": ["run"], "unit": "N m", "description": "brake torque"}
        >>> ArchiveDescription({}, contents={"variables": [torque]}).to_pandas().loc["torque", "unit"]
        'N m'
        """
        pandas = needed("pandas")
        columns = "name", "dims", "shape", "unit", "description"
        rows = [{name: row.get(name) for name in columns} for row in self.contents["variables"]]
        return pandas.DataFrame(rows).set_index("name")


@dataclass(frozen=True, eq=False, repr=False)
class ArchiveVerification(Result):
    """Whether an archive is whole: every checksum, unit and axis was read and checked.

    Attributes
    ----------
    path : str
    faults : sequence of str
        One line for each fault; none where the archive is whole.
    content_sha256 : str or None
        Digest over all that the archive holds; None where it is not whole.
    share : str or None
        Share of a sweep that the archive holds, e.g. "1/3"; None where it holds all runs.
    machine_differences : sequence of dict
        Keys in which it was made with another machine than the one that was given.
    """

    title: ClassVar[str] = "verification of an archive"

    path: str = field(kw_only=True)
    faults: Sequence[str] = field(kw_only=True)
    content_sha256: str | None = field(kw_only=True)
    share: str | None = field(default=None, kw_only=True)
    machine_differences: Sequence[dict[str, str]] = field(default=(), kw_only=True)

    @property
    def is_whole(self) -> bool:
        """Whether nothing is wrong with the file, and no planned run of its share is missing."""
        return not self.faults

    @property
    def sentence(self) -> str:
        """What was found, in words."""
        if self.faults:
            return self.faults[0]
        if self.share:
            return f"sound, a share of a sweep: {self.share}; archive merge joins it with the others"
        return "whole"

    def to_dict(self) -> dict[str, Any]:
        """Return the content of ``apesim archive verify --json``.

        Returns
        -------
        dict

        Examples
        --------
        >>> damaged = ArchiveVerification({}, path="a.h5", faults=["a.h5: torque: damaged"], content_sha256=None)
        >>> damaged.is_whole, damaged.to_dict()["faults"]
        (False, ['a.h5: torque: damaged'])
        """
        return {
            "file": self.path,
            "content_sha256": self.content_sha256,
            "share": self.share,
            "faults": list(self.faults),
            "machine_differences": list(self.machine_differences),
        }


@public
def describe_archive(path: str | PathLike[str], *, machine: Machine | None = None) -> ArchiveDescription:
    """Tell what an archive holds and where it comes from, without reading its runs.

    Parameters
    ----------
    path : path
        File of the archive.
    machine : Machine, optional
        Machine that it is compared with: `machine_differences` names the keys that differ.

    Returns
    -------
    ArchiveDescription

    Raises
    ------
    ArchiveError
        The file is missing, damaged, unsafe, no archive or of a newer format.
    InputError
        The machine holds what no machine file could say.

    Examples
    --------
    >>> import tempfile
    >>> import apesim
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = f"{folder}/map.h5"
    ...     found = apesim.map_valve(apesim.Machine(), pressure="0.8 MPa gauge", temperature="287 K", out=path)
    ...     described = apesim.describe_archive(path, machine=apesim.Machine().with_(valve_stroke="8 mm"))
    >>> described["runs"], described.is_whole
    (1, True)
    >>> [row["key"] for row in described.machine_differences]
    ['valve.stroke']
    """
    if machine is not None:
        arguments_of("describe_archive", machine)
    contents = info(path)
    contents["kind"] = kind_of((variable["name"] for variable in contents["variables"]), contents["provenance"])
    planned = contents["runs_planned"]
    gaps = sum(last - first + 1 for first, last in contents["missing_runs"])
    scalars = {
        "runs": Scalar(contents["runs"], "1", "runs in the file"),
        **({} if planned is None else {"runs_planned": Scalar(planned, "1", "runs of the whole sweep")}),
        "missing_runs": Scalar(gaps, "1", "runs of its share of the sweep that are missing"),
        "variables": Scalar(len(contents["variables"]), "1", "variables"),
        "bytes": Scalar(contents["bytes"], "1", "size of the file in bytes"),
    }
    return ArchiveDescription(
        scalars,
        conditions={"file": contents["path"]},
        machine=contents["machine"],
        contents=contents,
        machine_differences=differences_from(machine, [path], "describe_archive"),
    )


@public
def verify_archive(path: str | PathLike[str], *, machine: Machine | None = None) -> ArchiveVerification:
    """Check every checksum, unit and axis of an archive, and that no planned run is missing.

    Parameters
    ----------
    path : path
        File of the archive.
    machine : Machine, optional
        Machine that it is compared with, where the file is whole.

    Returns
    -------
    ArchiveVerification
        What is damaged stands in its `faults`; it is not raised.

    Raises
    ------
    InputError
        The machine holds what no machine file could say.

    Examples
    --------
    >>> import tempfile
    >>> import apesim
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = f"{folder}/map.h5"
    ...     found = apesim.map_valve(apesim.Machine(), pressure="0.8 MPa gauge", temperature="287 K", out=path)
    ...     verified = apesim.verify_archive(path)
    >>> verified.is_whole, len(verified.content_sha256)
    (True, 64)
    """
    if machine is not None:
        arguments_of("verify_archive", machine)
    faults = verify(path)
    verified = ArchiveVerification(
        {"faults": Scalar(len(faults), "1", "faults found")},
        conditions={"file": str(path)},
        path=str(path),
        faults=faults,
        content_sha256=None if faults else read_digest(path),
        share=None if faults else _share_of(path),
        machine_differences=[] if faults else differences_from(machine, [path], "verify_archive"),
    )
    return replace(verified, ending=verified.sentence)


def _share_of(path: str | PathLike[str]) -> str | None:
    """Share of a sweep that an archive holds; None where it holds all runs."""
    contents = info(path)
    planned = contents["runs_planned"]
    return contents["provenance"].get("shard") if planned is not None and contents["runs"] < planned else None
