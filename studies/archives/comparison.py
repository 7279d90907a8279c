"""Comparison of two archives by the coordinates of their runs."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from apesim.archive.comparison import Difference, Summary, diff, provenance_differences, summarise
from apesim.engine.machine import Machine
from apesim.march.error_bounds import MAX_TOLERANCE_CHANGE
from apesim.quantities import Arguments, Quantity
from apesim.results import Result, Scalar, needed
from apesim.studies.archives.machines import differences_from
from apesim.studies.execution.calls import arguments_of, public

if TYPE_CHECKING:
    import pandas

TOLERANCE = Quantity("", 0.0, 1e300, "a call")
SOLVER_TOLERANCE = MAX_TOLERANCE_CHANGE
"""Relative difference that counts as none unless another is given: the error that a run may have without a warning. So
the same results from another processor or another version of a compiler are the same."""


@dataclass(frozen=True, eq=False, repr=False)
class ArchiveComparison(Result):
    """What comparing two archives came to.

    Attributes
    ----------
    differences : sequence of Difference
        One for each variable and run that differ, for each key of the machine, axis and missing run.
    summary : sequence of Summary
        All differences of one name in one row.
    provenance : sequence of Difference
        Entries of the provenance that differ, such as the date; they do not make archives different.
    machine_differences : sequence of dict
        Keys in which they were made with another machine than the one that was given.
    """

    title: ClassVar[str] = "comparison of two archives"

    differences: Sequence[Difference] = field(kw_only=True)
    summary: Sequence[Summary] = field(kw_only=True)
    provenance: Sequence[Difference] = field(kw_only=True)
    machine_differences: Sequence[dict[str, str]] = field(default=(), kw_only=True)

    @property
    def is_same(self) -> bool:
        """Whether the archives agree within the tolerances, but for their provenance."""
        return not self.differences

    def to_dict(self) -> dict[str, Any]:
        """Return the content of ``apesim archive diff --json``.

        Returns
        -------
        dict

        Examples
        --------
        >>> counts = {name: Scalar(0) for name in ("runs_compared", "variables_same", "variables_different")}
        >>> ArchiveComparison(counts, differences=[], summary=[], provenance=[]).to_dict()["differences"]
        []
        """
        return {
            "runs_compared": self["runs_compared"],
            "variables_same": self["variables_same"],
            "variables_different": self["variables_different"],
            "summary": [row._asdict() for row in self.summary],
            "differences": [row._asdict() for row in self.differences],
            "provenance": [row._asdict() for row in self.provenance],
            "machine_differences": list(self.machine_differences),
        }

    def to_pandas(self) -> "pandas.DataFrame":
        """Make a table of the differences, one a row.

        Returns
        -------
        pandas.DataFrame
            Columns as in `apesim.archive.comparison.Difference`; no rows where the archives agree.

        Raises
        ------
        ImportError
            pandas is not installed.

        Examples
        --------
        >>> row = Difference("variable", "torque", 0, "", 3.0, 3.1, 1)
        >>> comparison = ArchiveComparison({}, differences=[row], summary=[], provenance=[])
        >>> comparison.to_pandas()["name"].tolist()
        ['torque']
        """
        return needed("pandas").DataFrame(self.differences, columns=Difference._fields)


@public
def compare_archives(
    path: str | PathLike[str],
    other: str | PathLike[str],
    *,
    rtol: float = SOLVER_TOLERANCE,
    atol: float = 0.0,
    machine: Machine | None = None,
) -> ArchiveComparison:
    """Compare two archives in machine, axes and results, by the coordinates of their runs.

    Parameters
    ----------
    path, other : path
        Files of the archives.
    rtol, atol : float
        Floats are equal within ``atol + rtol`` times the larger magnitude [SI]; all else must be the same. Beside the
        largest value of a variable, what is smaller than the solver's own error counts as zero. With ``rtol=0``
        floats have to be the same to the last bit.
    machine : Machine, optional
        Machine that both are compared with.

    Returns
    -------
    ArchiveComparison

    Raises
    ------
    ArchiveError
        One of them cannot be read.
    InputError
        A tolerance is negative, or the machine holds what no machine file could say.

    Examples
    --------
    >>> import tempfile
    >>> import apesim
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     paths = f"{folder}/cold.h5", f"{folder}/both.h5"
    ...     for path, temperature in zip(paths, ["280 K", "280:300:20 K"]):
    ...         found = apesim.map_valve(apesim.Machine(), pressure="0.8 MPa gauge", temperature=temperature, out=path)
    ...     compared = apesim.compare_archives(*paths)
    >>> compared.is_same, compared["runs_compared"], [row.kind for row in compared.differences]
    (False, 1, ['run'])
    """
    arguments = Arguments("compare_archives") if machine is None else arguments_of("compare_archives", machine)[0]
    arguments.quantity("rtol", rtol, TOLERANCE)
    arguments.quantity("atol", atol, TOLERANCE)
    arguments.refuse()
    compared = diff(Path(path), Path(other), rtol, atol, floor=min(rtol, SOLVER_TOLERANCE))
    summary = summarise(compared.differences)
    return ArchiveComparison(
        {
            "runs_compared": Scalar(compared.runs, "1", "runs that both have"),
            "variables_same": Scalar(compared.same, "1", "variables and axes that agree in all these runs"),
            "variables_different": Scalar(compared.different, "1", "variables and axes that do not"),
            "differences": Scalar(len(compared.differences), "1", "differences in all"),
        },
        conditions={"of": str(path), "and": str(other)},
        differences=compared.differences,
        summary=summary,
        provenance=provenance_differences(Path(path), Path(other)),
        machine_differences=differences_from(machine, [path, other], "compare_archives"),
    )
