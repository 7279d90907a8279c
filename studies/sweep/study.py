"""The function `sweep` for Python, which checks its arguments, and its result `Sweep`."""

import contextlib
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from apesim.archive import Archive
from apesim.archive.columns import values_of
from apesim.archive.grid import axes_of, grid_dataset
from apesim.engine.cylinder import EPV, INTAKES
from apesim.engine.machine import Machine
from apesim.quantities import Arguments, Choice, parse_range
from apesim.quantities.arguments import WithUnit
from apesim.quantities.settings import differences
from apesim.results import Scalar, name_of
from apesim.studies.archives.archive_result import ArchiveResult
from apesim.studies.drawing.axes import axes_for, check_plotted, in_house_style
from apesim.studies.execution.calls import arguments_of, call_text, public
from apesim.studies.execution.cluster import connected
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.execution.progress import Progress, show_progress
from apesim.studies.run.operating_conditions import JOBS, SPEED
from apesim.studies.sweep.plan import FIXED, TIMING_NAMES, TIMINGS, rpm, span_of
from apesim.studies.sweep.results import faults_of, warnings_of
from apesim.studies.sweep.run import find_finished, run_sweep
from apesim.studies.sweep.variation import Vary, read_variation

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

SPEEDS = "300:2400:100 rpm"
INTAKE = Choice(INTAKES, "a call")
TIMING = Choice((*TIMING_NAMES, "both"), "a call")


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(ArchiveResult):
    """Result of a sweep: operating points over speeds, intakes, timings and keys of the machine.

    Attributes
    ----------
    was_finished : bool
        The archive was there and whole already, and nothing was computed.
    made_by : str
        Call that made the archive, where the sweep was resumed by the name of its archive alone; else "".
    """

    title: ClassVar[str] = "sweep of operating points"

    was_finished: bool = field(default=False, kw_only=True)
    made_by: str = field(default="", kw_only=True)

    @classmethod
    def _faults_of(cls, archive: Archive) -> Iterable[str]:
        """Write one line for each point that is out of reach, failed or did not reach a periodic state."""
        return faults_of(archive)

    @classmethod
    def _warnings_of(cls, archive: Archive) -> Iterable[str]:
        """Write one line for each kind of warning that runs have."""
        return warnings_of(archive)

    @classmethod
    def _summary_of(cls, archive: Archive) -> Mapping[str, Scalar]:
        """Find the highest brake torque [N m] and the lowest specific air [kg/kWh]; none where all runs are NaN."""
        v = values_of(archive)
        torque, air = v["brake_torque_Nm"], v["specific_air_kg_per_kWh"]
        summary = {}
        if not np.isnan(torque).all():
            summary["max_brake_torque"] = Scalar(
                float(np.nanmax(torque)), "N m", "highest mean brake torque of all runs"
            )
        if not np.isnan(air).all():
            text = "lowest consumption of all air over brake work of all runs"
            summary["min_specific_air_kg_per_kWh"] = Scalar(float(np.nanmin(air)), "kg/kWh", text)
        return summary

    @classmethod
    def _conditions_of(cls, archive: Archive) -> Mapping[str, str]:
        """Write the values of each axis in words, by its name: all of a few, else the ends and their number."""
        return {name.removesuffix("_rpm"): span_of(texts) for name, texts in axes_of(archive).items()}

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary with the keys of ``apesim engine sweep --json``.

        Returns
        -------
        dict
            Number of runs, what was swept, and what went wrong.

        Examples
        --------
        >>> import apesim
        >>> apesim.sweep(apesim.Machine(), speed="900 rpm", intake="ideal").to_dict()["axes"]
        {'actuation': ['ideal'], 'speed_rpm': ['900 r/min']}
        """
        return {
            "runs": self["runs"],
            "axes": axes_of(self.archive),
            "faults": list(self.failed),
            "warnings": list(self.warnings),
            "was_finished": self.was_finished,
        }

    def to_xarray(self) -> "xarray.Dataset":
        """Lay all runs out over the axes that were swept, as an xarray dataset.

        Each variable has the attributes ``units`` and ``long_name``.

        Returns
        -------
        xarray.Dataset
            Points that are missing are NaN.

        Raises
        ------
        ImportError
            xarray is not installed.

        Examples
        --------
        >>> import apesim
        >>> swept = apesim.sweep(apesim.Machine(), speed="900 rpm", intake="ideal")
        >>> dict(swept.to_xarray()["brake_torque"].sizes)
        {'actuation': 1, 'speed_rpm': 1}
        """
        data = grid_dataset(self.archive)
        names = {name: name_of(name, variable.unit) for name, variable in self.archive.variables.items()}
        return data.rename({name: short for name, short in names.items() if name != short and name in data.variables})

    @in_house_style
    def plot(self, ax: "Axes | None" = None, what: str = "brake_torque") -> "Axes":
        """Draw a variable over speed: a line for each actuation, and for each value of the keys that were varied.

        Where there are more than 12 lines, some values are drawn, and the title says of how many.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; those of a new figure if left out.
        what : str
            Name of a variable, e.g. "specific_air_kg_per_kWh".

        Returns
        -------
        matplotlib.axes.Axes
            Axes that were drawn on.

        Examples
        --------
        >>> import apesim
        >>> swept = apesim.sweep(apesim.Machine(), speed="900 rpm", intake="ideal")
        >>> axes = swept.plot()
        >>> axes.get_xlabel(), axes.get_ylabel()
        ('speed [r/min]', 'mean brake torque [N m]')
        """
        from apesim.studies.drawing.panels import label_axes
        from apesim.studies.drawing.style import Look
        from apesim.studies.sweep.figures import WIDE, draw_over_speed

        check_plotted(what, self.traces)
        is_crowded = ax is None and len(axes_of(self.archive)) > 2
        beside: Look = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0)} if is_crowded else {}
        ax, trace = axes_for(ax, figsize=WIDE if is_crowded else None), self.traces[what]
        unit = "" if trace.unit == "1" else trace.unit
        label_axes(ax, x=("speed", "r/min"), y=(trace.long_name, unit))
        draw_over_speed(ax, self.archive, trace.values, **beside)
        return ax


@public
def sweep(
    machine: Machine,
    speed: WithUnit | Iterable[WithUnit] = SPEEDS,
    *,
    intake: str | Iterable[str] = INTAKES,
    timing: str = "both",
    vary: Vary | None = None,
    traces: bool = True,
    out: str | PathLike[str] | None = None,
    jobs: int | None = 1,
    dask: str | None = None,
    shard: str | None = None,
    resume: bool = False,
    overwrite: bool = False,
    progress: Progress = False,
    call: str | None = None,
) -> Sweep:
    """Run operating points over speeds, intakes, timings and any keys of the machine.

    Parameters
    ----------
    machine : Machine
        Machine to run.
    speed : str, (array, str) or sequence of them
        Speeds with their unit: a range such as "300:2400:100 rpm", a list, or ``(array, "rpm")``.
    intake : str or sequence of str
        What opens the intake: one or more of "epv", "cam" and "ideal".
    timing : {"fixed", "corrected", "both"}
        Command angles of the electro-pneumatic valve: the machine's, or those by which it meets its targets.
    vary : mapping of str, or sequence of str, optional
        Ranges by keys of the machine, e.g. ``{"supply.pressure": "0.6:1.4:0.2 MPa gauge"}``, or ``KEY=RANGE``.
    traces : bool
        Keep the traces over crank angle, too: nearly all of the room that results take, some 63 kB for each run.
    out : path, optional
        The archive to write; what is finished survives a kill. Left out, all stays in memory.
    jobs : int or None
        Processes; None: as many as the work is worth. A script that asks for more than one does so below
        ``if __name__ == "__main__":``, as each process imports it.
    dask : str, optional
        Address of the scheduler of a cluster, on which to compute instead.
    shard : str, optional
        "i/N": only every N-th point from the i-th.
    resume : bool
        Go on with a sweep that was interrupted; one that is finished stays as it is, and is read whatever was swept
        where neither the machine nor an argument says what to sweep.
    overwrite : bool
        Replace an archive that is there.
    progress : bool or function
        True: a bar on standard error; a function is called with the numbers of points done and in all.
    call : str, optional
        What the archive notes as its call; made from the arguments if left out.

    Returns
    -------
    Sweep
        ``failed`` names the points without a good result.

    Raises
    ------
    InputError
        The machine or an argument is out of range, or two arguments do not go together.
    ArchiveError
        The target exists, or another process writes it, or it cannot be written.

    Examples
    --------
    >>> import apesim
    >>> found = apesim.sweep(apesim.Machine(), speed="900 rpm", intake="ideal")
    >>> found["runs"], found.failed
    (1, ())
    >>> found.traces["brake_torque"]
    <Trace [N m] over 1 run, 40.533 to 40.533>
    """
    call = call_text(sweep, locals()) if call is None else call
    arguments, machine = arguments_of("sweep", machine)
    speeds = _once(arguments, "speed", arguments.range("speed", speed, SPEED), lambda value: f"{rpm(value):g} r/min")
    intakes = _once(arguments, "intake", arguments.range("intake", intake, INTAKE), INTAKES.__getitem__)
    timings = _timings(arguments, timing, intakes)
    variation = read_variation(arguments, machine, vary)
    arguments.quantity("jobs", jobs, JOBS)
    share = _share(arguments, shard)

    # Arguments that are right each by itself, but do not go together.
    if dask and (jobs or 1) > 1:
        arguments.fault("jobs", "is for this machine, not for `dask`", "leave one out")
    if out is None and (resume or shard):
        arguments.fault("out", "is left out, so that nothing is kept", "give the path of an archive")
    arguments.refuse()

    # Resumed by the name of its archive alone, a finished sweep is read, whatever was swept.
    says_nothing = traces and not (shard or vary) and (intakes, timings) == (list(range(len(INTAKES))), TIMINGS)
    if out is not None and resume and not overwrite and says_nothing and not any(differences(machine)):
        finished = find_finished(out) if speeds == parse_range(SPEEDS, SPEED) else None
        if finished:
            made_by = finished.archive.provenance.get("command", "")
            swept = Sweep.of(finished.archive, finished.seconds, was_finished=True, made_by=made_by)
            return replace(swept, warnings=(*swept.warnings, *finished.notes))

    # Without a target the archive lies in a folder that is gone with the block; by then its results are in memory.
    with contextlib.ExitStack() as stack:
        target = Path(out) if out is not None else Path(stack.enter_context(tempfile.TemporaryDirectory()), "sweep.h5")
        cluster = stack.enter_context(connected(dask)) if dask else None
        report = stack.enter_context(show_progress(progress, "sweep"))
        done = run_sweep(
            machine,
            speeds,
            intakes,
            target,
            timings=timings,
            variation=variation,
            traces=traces,
            jobs=jobs,
            cluster=cluster,
            shard=share,
            resume=resume,
            overwrite=overwrite,
            command=call,
            report=report,
            warm_up=lambda function, *first: call_in_thread(function, *first).result(),
        )
    swept = Sweep.of(done.archive, done.seconds, failed=done.faults, was_finished=done.was_finished)
    return replace(swept, warnings=(*swept.warnings, *done.notes))


def _once(arguments: Arguments, name: str, values: list, text_of: Callable[[Any], str]) -> list:
    """Note a fault for each value of an argument that is given twice; returns the values."""
    for value in dict.fromkeys(values):
        if values.count(value) > 1:
            arguments.fault(name, f"{text_of(value)} is given twice", "give it once")
    return values


def _timings(arguments: Arguments, timing: Any, intakes: list[int]) -> tuple[int, ...]:
    """Codes of the timings that an argument names."""
    code = arguments.quantity("timing", timing, TIMING)
    if code is None:
        if timing is None:
            arguments.fault("timing", "is None", f"write {TIMING.range_text}")
        return (FIXED,)
    if TIMING.options[code] == "corrected" and intakes and EPV not in intakes:
        wrong = "corrects the commands of an electro-pneumatic valve, but `intake` has none"
        arguments.fault("timing", wrong, 'add epv to `intake`, or write "fixed"')
    return TIMINGS if TIMING.options[code] == "both" else (TIMINGS[code],)


def _share(arguments: Arguments, text: str | None) -> tuple[int, int] | None:
    """Read the share (i, N) of a text "i/N"; a fault is noted where it is none."""
    if text is None:
        return None
    number, slash, total = str(text).partition("/")
    if not (slash and number.isdecimal() and total.isdecimal() and 1 <= int(number) <= int(total)):
        arguments.fault("shard", f"{text!r} is no share of the work", "write e.g. 1/4")
        return None
    return int(number), int(total)
