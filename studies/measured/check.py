"""Measured data judged before anything is fitted: whether they can be what they are said to be."""

import html
import time
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from apesim.engine.machine import Machine
from apesim.quantities import Fault, InputError
from apesim.studies.drawing.axes import axes_for, in_house_style
from apesim.studies.execution.calls import public
from apesim.studies.measured import Measured
from apesim.studies.measured.arguments import Tell, open_measured
from apesim.studies.measured.plausibility import Finding, Kind, examine, group_findings
from apesim.studies.measured.plausibility.expected import Expected

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredCheck:
    """What the checks of plausibility say of measured data.

    Attributes
    ----------
    machine : Machine
    measured : Measured
    findings : sequence of Finding
        Faults first, then warnings, then hints.
    expected : sequence of Expected or None
        What the machine shows of each run as it is stated; None: it could not be simulated.
    wall_time_s : float
        Computing time of the call [s].
    """

    machine: Machine
    measured: Measured
    findings: Sequence[Finding]
    expected: Sequence[Expected | None]
    wall_time_s: float = 0.0

    @property
    def faults(self) -> list[Finding]:
        """What cannot be physics of a rig anywhere near the machine: nothing is fitted to such data."""
        return [finding for finding in self.findings if finding.kind == Kind.FAULT]

    @property
    def warnings(self) -> list[Finding]:
        """What may be real, and more often is not."""
        return [finding for finding in self.findings if finding.kind == Kind.WARNING]

    @property
    def hints(self) -> list[Finding]:
        """What is good to know."""
        return [finding for finding in self.findings if finding.kind == Kind.HINT]

    def to_dict(self) -> dict[str, Any]:
        """Return the content of ``apesim measured check --json``.

        Returns
        -------
        dict

        Examples
        --------
        >>> import apesim
        >>> from apesim.studies.gap.example_bench import read_example
        >>> check = apesim.check_measured(apesim.Machine(), read_example())
        >>> check.to_dict()["faults"], check.to_dict()["runs"]
        ([], 4)
        """
        return {
            "bench": str(self.measured.bench),
            "runs": len(self.measured.runs),
            "faults": [_describe(finding) for finding in self.faults],
            "warnings": [_describe(finding) for finding in self.warnings],
            "hints": [_describe(finding) for finding in self.hints],
            "notes": list(self.measured.hints),
            "read": {file: str(table) for file, table in self.measured.read.items()},
            "wall_time_s": self.wall_time_s,
        }

    @in_house_style
    def plot(self, ax: "Axes | None" = None, run: str | None = None, channel: str | None = None) -> "Axes":
        """Draw a channel of a run over the machine, with what was found.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; those of a new figure if left out.
        run : str, optional
            File of the run; the first with a finding, else the first, if left out.
        channel : str, optional
            Name of the channel; the first of the run if left out.

        Returns
        -------
        matplotlib.axes.Axes
            Axes that were drawn on.

        Raises
        ------
        InputError
            There is no such trace.

        Examples
        --------
        >>> import apesim
        >>> from apesim.studies.gap.example_bench import read_example
        >>> axes = apesim.check_measured(apesim.Machine(), read_example()).plot(run="p40.csv")
        >>> axes.get_xlabel(), axes.get_ylabel()
        ('time [ms]', 'lift [mm]')
        """
        from apesim.studies.drawing.panels import add_legend
        from apesim.studies.measured.figures import draw_channel

        runs = [number for number, each in enumerate(self.measured.runs) if each.channels]
        if not runs:
            right = "draw means over speed by apesim.explain(...).plot()"
            raise InputError([Fault("plot()", "measured", "has means alone, and no trace to draw", right)])
        found = [finding.run for finding in self.findings if finding.run in runs]
        chosen = [number for number in (*found, *runs) if run in (None, self.measured.runs[number].data)]
        if not chosen or (channel and channel not in self.measured.runs[chosen[0]].channels):
            known = ", ".join(f"{each.data}: {' '.join(each.channels)}" for each in self.measured.runs if each.channels)
            wrong = f"there is no trace of {channel or 'any channel'} of {run or 'any run'}"
            raise InputError([Fault("plot()", "channel" if channel else "run", wrong, f"give one of {known}")])
        number = chosen[0]
        channel = channel or next(iter(self.measured.runs[number].channels))
        ax = draw_channel(axes_for(ax), self, number, channel)
        add_legend(ax)
        return ax

    def write(self, folder: str | PathLike[str], *, overwrite: bool = False) -> list[Path]:
        """Draw all runs over the machine, with what was found, into a folder.

        Parameters
        ----------
        folder : path
            Is made where it does not exist.
        overwrite : bool
            Whether to write into a folder that holds something.

        Returns
        -------
        list of Path
            A PNG and a PDF of each page.

        Raises
        ------
        ArchiveError
            The folder cannot be made, or is not empty.

        Examples
        --------
        >>> from tempfile import TemporaryDirectory
        >>> import apesim
        >>> from apesim.studies.gap.example_bench import read_example
        >>> check = apesim.check_measured(apesim.Machine(), read_example())
        >>> with TemporaryDirectory() as folder:
        ...     [path.name for path in check.write(folder)]
        ['runs_1.png', 'runs_1.pdf']
        """
        from apesim.studies.execution.output import make_folder
        from apesim.studies.measured.figures import measured_figures

        make_folder(folder, overwrite)
        return measured_figures(self, folder)

    @property
    def summary(self) -> str:
        """How many faults, warnings and hints there are in how many runs, in words."""
        counts = [
            f"{len(found)} {name}{'' if len(found) == 1 else 's'}"
            for name, found in (("fault", self.faults), ("warning", self.warnings), ("hint", self.hints))
        ]
        number = len(self.measured.runs)
        return f"{', '.join(counts)} in {number} run{'' if number == 1 else 's'}"

    def __repr__(self) -> str:
        lines = [
            f"  {finding.kind}: {finding}" + (f" [and {more} more]" if more else "")
            for finding, more in group_findings(self.findings)
        ]
        return "\n".join([f"MeasuredCheck: {self.summary}", *lines])

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{finding.kind}</td>"
            + "".join(f"<td>{html.escape(text)}</td>" for text in _describe(finding).values())
            + "</tr>"
            for finding in self.findings
        )
        names = "<th></th><th>check</th><th>file</th><th>channel</th><th>seen</th><th>likely reason</th><th>right</th>"
        return f"{html.escape(self.summary)}<table><tr>{names}</tr>{rows}</table>"


@public
def check_measured(
    machine: Machine, measured: Measured | str | PathLike[str], *, progress: Tell | None = None
) -> MeasuredCheck:
    """Check whether measured data can be what ``measured.toml`` says, before anything is fitted to them.

    Each run is compared with what the machine shows of it, so coarsely that no effect of the library is called a fault.

    Parameters
    ----------
    machine : Machine
    measured : Measured or path
        Measured data, see `read_measured`, or their folder.
    progress : callable, optional
        Called with the name of the stage, what is done of it and what there is to do.

    Returns
    -------
    MeasuredCheck

    Raises
    ------
    InputError
        An argument is wrong, or the folder cannot be read.

    Examples
    --------
    A gauge pressure whose header says abs:

    >>> import tempfile
    >>> from pathlib import Path
    >>> import apesim
    >>> run = apesim.run_valve(apesim.Machine(), supply="0.4 MPa gauge")
    >>> table = (run.to_pandas()[["pressure_b"]] - 101325.0).rename(columns={"pressure_b": "pressure_b [Pa abs]"})
    >>> about = ['bench = "valve"', "[[run]]", 'data = "a.csv"', 'supply = "0.4 MPa gauge"', 'pulse = "50 ms"']
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "a.csv").write_text(table.rename_axis("time [s]").to_csv())
    ...     _ = Path(folder, "measured.toml").write_text(chr(10).join(about))
    ...     check = apesim.check_measured(apesim.Machine(), folder)
    >>> [fault.reason for fault in check.faults]
    ['gauge called abs?']
    """
    start = time.perf_counter()
    machine, measured, _ = open_measured("check_measured", machine, measured)
    examination = examine(machine, measured, progress)
    return MeasuredCheck(machine, measured, examination.findings, examination.expected, time.perf_counter() - start)


def _describe(finding: Finding) -> dict[str, Any]:
    """A finding as JSON has it."""
    return {
        "check": str(finding.check),
        "file": finding.file,
        "channel": finding.channel,
        "seen": finding.seen,
        "reason": finding.reason,
        "right": finding.right,
    }
