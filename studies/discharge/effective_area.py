"""The effective area of a solenoid valve from discharge tests, as a result."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf, nan
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from apesim.air import gas_of
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.quantities.arguments import Given
from apesim.results import NotConverged, Result, Trace, scalars_of
from apesim.studies.discharge.evaluation import HEADER, Discharge, discharge
from apesim.studies.discharge.records import Record, read_tests
from apesim.studies.discharge.summary import discharge_json
from apesim.studies.discharge.vessel import Vessel
from apesim.studies.drawing.axes import axes_for, in_house_style
from apesim.studies.execution.calls import arguments_of, public
from apesim.studies.execution.output import refuse_to_replace, write_traces
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.execution.progress import Progress, show_progress
from apesim.studies.run.operating_conditions import TEMPERATURE, VOLUME

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NUMBERS = {
    "effective_area_mm2": ("mm^2", "effective area of the open valve"),
    "effective_area_half_band_mm2": ("mm^2", "half of its 95 % band, by noise alone"),
    "opens_s": ("s", "time after the switch at which the valve begins to open"),
    "open_s": ("s", "time after the switch at which the valve is open"),
    "cut_off_s": ("s", "time after the switch from which on the tests tell nothing"),
    "wall_time_s": ("s", "computing time of the call"),
}
CURVE = {
    "opening": ("1", "share of the full effective area"),
    "effective_area": ("m^2", "effective area"),
    "low": ("m^2", "lower end of its 95 % band"),
    "high": ("m^2", "upper end of its 95 % band"),
}


@dataclass(frozen=True, eq=False, repr=False)
class EffectiveArea(Result):
    """Effective area of a solenoid valve over the time after its switch, from discharge tests.

    Attributes
    ----------
    evaluation : Discharge
        Each test and all together, for those who look deeper.
    vessel : Vessel
    """

    title: ClassVar[str] = "effective area from discharge tests"

    evaluation: Discharge = field(kw_only=True)
    vessel: Vessel = field(kw_only=True)

    def to_dict(self) -> dict[str, Any]:
        """Return the result under the keys of ``apesim valve discharge --json``; NaN where JSON says null.

        Returns
        -------
        dict
            See `apesim.studies.discharge.summary.discharge_json`; besides ``warnings``.

        Examples
        --------
        >>> import tempfile
        >>> import apesim
        >>> times = np.arange(-5.0, 60.0, 0.5)
        >>> rows = np.column_stack((times, 0.7 / (1.0 + np.clip(times, 0.0, None) / 400.0) ** 7))
        >>> folder = tempfile.TemporaryDirectory()
        >>> test, form = f"{folder.name}/p060.csv", "time [ms],pressure [MPa abs]"
        >>> np.savetxt(test, rows, delimiter=",", header=form, comments="")
        >>> area = apesim.evaluate_discharge(apesim.Machine(), [test], volume="500 cm^3")
        >>> area.to_dict()["effective_area_mm2"] == area["effective_area_mm2"]
        True
        >>> folder.cleanup()
        """
        return discharge_json(self.evaluation, self.vessel) | {"warnings": list(self.warnings)}

    def write(self, out: str | PathLike[str], *, overwrite: bool = False) -> Path:
        """Write the curve as CSV, which ``valve.solenoid.opening_curve`` takes.

        Parameters
        ----------
        out : path
            CSV to write.
        overwrite : bool
            Whether one that is there may be replaced.

        Returns
        -------
        Path
            The CSV.

        Raises
        ------
        ArchiveError
            There is one that is not to be replaced.
        NotConverged
            The tests give no curve, as the first of the warnings says.

        Examples
        --------
        >>> import tempfile
        >>> import apesim
        >>> times = np.arange(-5.0, 60.0, 0.5)
        >>> rows = np.column_stack((times, 0.7 / (1.0 + np.clip(times, 0.0, None) / 400.0) ** 7))
        >>> folder = tempfile.TemporaryDirectory()
        >>> test, form = f"{folder.name}/p060.csv", "time [ms],pressure [MPa abs]"
        >>> np.savetxt(test, rows, delimiter=",", header=form, comments="")
        >>> area = apesim.evaluate_discharge(apesim.Machine(), [test], volume="500 cm^3")
        >>> area.write(f"{folder.name}/curve.csv").read_text().splitlines()[0]
        'time [ms],opening [-],effective_area [mm^2],low [mm^2],high [mm^2]'
        >>> folder.cleanup()
        """
        if self.evaluation.refusal:
            wrong, _, right = self.evaluation.refusal.partition("? ")
            raise NotConverged("discharge tests", f"{wrong}?", right, self)
        refuse_to_replace(out, overwrite=overwrite)
        write_traces(Path(out), HEADER, self.evaluation.curve * np.array([1e3, 1.0, 1e6, 1e6, 1e6]))
        return Path(out)

    def draw(self, folder: str | PathLike[str]) -> list[Path]:
        """Draw all figures into a folder, as PNG and PDF.

        Parameters
        ----------
        folder : path
            Made if it does not exist.

        Returns
        -------
        list of Path
            A PNG and a PDF of each figure.

        Examples
        --------
        >>> import tempfile
        >>> import apesim
        >>> times = np.arange(-5.0, 60.0, 0.5)
        >>> rows = np.column_stack((times, 0.7 / (1.0 + np.clip(times, 0.0, None) / 400.0) ** 7))
        >>> folder = tempfile.TemporaryDirectory()
        >>> test, form = f"{folder.name}/p060.csv", "time [ms],pressure [MPa abs]"
        >>> np.savetxt(test, rows, delimiter=",", header=form, comments="")
        >>> area = apesim.evaluate_discharge(apesim.Machine(), [test], volume="500 cm^3")
        >>> [path.name for path in area.draw(f"{folder.name}/figures")]  # doctest: +SKIP
        ['pressure.png', 'pressure.pdf', 'effective_area.png', 'effective_area.pdf']
        >>> folder.cleanup()
        """
        from apesim.studies.discharge.figures import discharge_figures

        return discharge_figures(self.vessel, self.evaluation, folder)

    @in_house_style
    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the effective area over time, with its 95 % band.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; those of a new figure if left out.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Examples
        --------
        >>> import tempfile
        >>> import apesim
        >>> times = np.arange(-5.0, 60.0, 0.5)
        >>> rows = np.column_stack((times, 0.7 / (1.0 + np.clip(times, 0.0, None) / 400.0) ** 7))
        >>> folder = tempfile.TemporaryDirectory()
        >>> test, form = f"{folder.name}/p060.csv", "time [ms],pressure [MPa abs]"
        >>> np.savetxt(test, rows, delimiter=",", header=form, comments="")
        >>> area = apesim.evaluate_discharge(apesim.Machine(), [test], volume="500 cm^3")
        >>> area.plot().get_ylabel()
        'effective area [mm²]'
        >>> folder.cleanup()
        """
        ax = axes_for(ax)
        milliseconds = 1e3 * self.traces["time"].values
        low, area, high = (1e6 * self.traces[name].values for name in ("low", "effective_area", "high"))
        ax.fill_between(milliseconds, low, high, alpha=0.2, lw=0.0)
        ax.plot(milliseconds, area)
        ax.set(xlabel="time after the switch [ms]", ylabel="effective area [mm²]")
        return ax


@public
def evaluate_discharge(
    machine: Machine,
    files: Sequence[str | PathLike[str]],
    *,
    volume: Given,
    temperature: Given | None = None,
    isothermal: bool = False,
    out: str | PathLike[str] | None = None,
    overwrite: bool = False,
    progress: Progress = False,
) -> EffectiveArea:
    """Find the effective area of a solenoid valve from discharge tests: Eq. 10 of the EPV paper.

    The EPV paper [1]_ tests while the valve opens. A discharge test of an open valve, which gives its sonic conductance
    and critical pressure ratio, is ISO 6358-2 [2]_.

    The area of the open valve is that of the choked part. Heat that the wall gives to the gas is fitted beside it, as
    one conductance, where the tests tell it; otherwise the vessel is taken as adiabatic.

    Parameters
    ----------
    machine : Machine
        Its gas and ambient air are those of the tests.
    files : sequence of path
        One for each test: CSV of time and pressure; or a folder whose ``measured.toml``, with ``bench = "discharge"``,
        names them and says how they are written.
    volume : str or float
        Volume of the vessel, e.g. "50 cm^3", or [m^3].
    temperature : str or float, optional
        Temperature of the air at the start, e.g. "293 K", or [K]; the ambient one if left out.
    isothermal : bool
        The vessel is full of wire, and keeps its temperature, as in ISO 6358-2.
    out : path, optional
        The curve to write, as CSV.
    overwrite : bool
        Replace one that is there.
    progress : bool or function
        True: a bar on standard error; a function is called with the numbers of tests done and in all.

    Returns
    -------
    EffectiveArea

    Raises
    ------
    InputError
        A file cannot be read, or the tests are too noisy.
    NotConverged
        A curve is to be written, and the tests give none.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eqs. 9 and 10.
    .. [2] ISO 6358-2:2019, "Pneumatic fluid power - Determination of flow-rate characteristics of components using
       compressible fluids - Part 2: Alternative test methods".

    Examples
    --------
    A vessel of 500 cm^3 that empties from 0.7 MPa, choked and without heat from its wall:

    >>> import tempfile
    >>> import apesim
    >>> import numpy as np
    >>> times = np.arange(-2.0, 60.0, 0.1)
    >>> pressures = 0.7 / (1.0 + np.clip(times, 0.0, None) / 400.0) ** 7
    >>> pressures += 1e-4 * np.random.default_rng(1).normal(size=len(times))
    >>> rows = np.column_stack((times, pressures))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     np.savetxt(f"{folder}/p.csv", rows, "%.9g", ",", header="time [ms],pressure [MPa abs]", comments="")
    ...     area = apesim.evaluate_discharge(apesim.Machine(), [f"{folder}/p.csv"], volume="500 cm^3")
    >>> area.traces["effective_area"].unit
    'm^2'
    """
    arguments, machine = arguments_of("evaluate_discharge", machine)
    ambient = machine.ambient
    size = arguments.quantity("volume", volume, VOLUME)
    kelvin = arguments.quantity("temperature", temperature, TEMPERATURE)

    # The tests are read before anything is refused, so that faults of arguments and of files come out together.
    records: list[Record] = []
    if not files:
        arguments.fault("files", "no discharge test", "give the CSV of at least one")
    try:
        records = read_tests(files, ambient.pressure)
    except InputError as error:
        arguments.faults += error.faults
    arguments.refuse()
    if out is not None:
        refuse_to_replace(out, overwrite=overwrite)

    # The evaluation, in another thread, so that Ctrl-C is heard at once. The time is that of it alone.
    start = time.perf_counter()
    initial = ambient.temperature if kelvin is None else float(kelvin)
    vessel = Vessel(float(size), initial, ambient.pressure, gas_of(machine.air), inf if isothermal else 0.0)
    with show_progress(progress, "discharge") as report:
        result = call_in_thread(discharge, vessel, records).result()
        report(len(records), len(records))

    # What was found, as numbers and as curves; where there is no curve, its times are NaN.
    values = {
        "effective_area_mm2": 1e6 * result.full_area,
        "effective_area_half_band_mm2": 1e6 * result.full_area_half_band,
        "opens_s": result.curve[0, 0] if len(result.curve) else nan,
        "open_s": result.curve[-1, 0] if len(result.curve) else nan,
        "cut_off_s": result.end,
        "wall_time_s": time.perf_counter() - start,
    }
    times, *columns = result.curve.T
    traces = {"time": Trace(("time",), times, "s", "time after the switch")}
    for (name, about), column in zip(CURVE.items(), columns, strict=True):
        traces[name] = Trace(("time",), column, *about)
    conditions = {"volume": f"{1e6 * vessel.volume:g} cm^3", "temperature": f"{vessel.temperature:g} K"}
    if isothermal:
        conditions["heat"] = "isothermal"
    area = EffectiveArea(
        scalars_of(values, NUMBERS),
        traces,
        conditions,
        tuple(result.warnings),
        machine=machine.to_toml(),
        evaluation=result,
        vessel=vessel,
    )

    # The result refuses to write where there is no curve; whether a file may be replaced is settled above.
    if out is not None:
        area.write(out, overwrite=True)
    return area
