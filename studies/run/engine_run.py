"""One operating point of the engine at its periodic state, as a result."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import cycle
from math import isnan
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cylinder import INTAKES
from apesim.engine.drivetrain.indicators import SHAFT_INDICATORS, VALVE_INDICATORS
from apesim.engine.drivetrain.point import PointRun, run_point
from apesim.engine.drivetrain.rates import SHAFT_TRACE
from apesim.engine.drivetrain.steady import Revolution
from apesim.engine.exergy import TERMS
from apesim.engine.indicators import COUNTS, FLAGS, INDICATORS
from apesim.engine.machine import Machine
from apesim.engine.steady import SteadyRun
from apesim.march.adaptive import Status
from apesim.quantities import split_header
from apesim.quantities.arguments import WithUnit
from apesim.results import NotConverged, Result, Trace, name_of, scalars_of
from apesim.studies.drawing.axes import axes_for, check_plotted, in_house_style
from apesim.studies.execution.calls import arguments_of, public, text_writer
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.run.compiling import compile_point
from apesim.studies.run.operating_conditions import SPEED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CLOSURES = {
    "mass": "mass_closure",
    "energy": "energy_closure",
    "exergy": "exergy_closure",
    "work_by_quadrature": "work_by_quadrature_change",
    "work_at_tenfold_tolerance": "work_tolerance_change",
    "air_at_tenfold_tolerance": "air_tolerance_change",
}
"""How closely a cycle closes: the key in JSON, and the name of the indicator."""
NUMBERS = (
    INDICATORS
    | SHAFT_INDICATORS
    | {
        "speed_swing": ("1", "estimated (highest - lowest)/mean speed of a shaft with the machine's inertia"),
        "wall_time_s": ("s", "computing time of the call"),
    }
)
TRACE_NAMES = {
    "cylinder_pressure": "cylinder pressure",
    "cylinder_temperature": "cylinder temperature",
    "lift": "lift of the intake",
    "velocity": "velocity of the lift, positive as it opens",
    "pressure_a": "pressure of chamber A, which pushes to closed",
    "pressure_b": "pressure of chamber B, which pushes to open",
    "groove_flow": "flow through the groove into the cylinder",
    "torque": "indicated torque",
    "receiver_pressure": "pressure in the receiver",
    "exhaust_flow": "flow through the exhaust valves out of the cylinder",
    "cylinder_volume": "cylinder volume",
}
"""What each trace of a cycle is."""
AXES = {
    "crank_angle_deg": (1.0, "crank angle after TDC [deg]"),
    "cylinder_volume": (1e-6, "cylinder volume [cm³]"),
    "cylinder_pressure": (1e6, "cylinder pressure [MPa abs]"),
    "lift": (1e-3, "lift [mm]"),
}
"""Unit in SI and label of the traces that are drawn."""
TORQUE = TRACE.index("torque [N m]")
"""Column of a trace."""
PLOTS = {
    "cylinder pressure": ("crank_angle_deg", "cylinder_pressure"),
    "lift": ("crank_angle_deg", "lift"),
    "indicator diagram": ("cylinder_volume", "cylinder_pressure"),
}
"""What a run draws: traces of both axes."""


@dataclass(frozen=True, eq=False, repr=False)
class EngineRun(Result):
    """One operating point at its periodic state; numbers as ``apesim engine run --json`` has them, traces as its CSV.

    Of several cylinders the numbers are totals, those of a valve that of the first one, and the traces have a second
    axis.

    Attributes
    ----------
    cylinders : tuple of dict
        Numbers of each cylinder, keys as in `scalars` with their units; angles are its own.
    march : SteadyRun or Revolution
        Last cycle of the march, for those who look deeper.
    """

    title: ClassVar[str] = "one operating point of the engine"
    headline: ClassVar[tuple[str, ...]] = (
        "brake_torque",
        "brake_power",
        "specific_air_kg_per_kWh",
        "exergy_efficiency",
        "valve_open_deg",
        "valve_close_deg",
    )

    cylinders: tuple[dict[str, float], ...] = field(default=(), kw_only=True)
    march: SteadyRun | Revolution = field(kw_only=True)

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary with the keys of ``apesim engine run --json``.

        Returns
        -------
        dict
            Indicators, exergy of a cycle, closures, what each cylinder does, and warnings; NaN where JSON says null.

        Examples
        --------
        >>> import apesim
        >>> run = apesim.run_engine(apesim.Machine(), speed="1000 rpm")
        >>> data = run.to_dict()
        >>> data["speed_rpm"], sorted(data["closure"])[:3]
        (1000.0, ['air_at_tenfold_tolerance', 'energy', 'exergy'])
        """
        left_out = {*CLOSURES.values(), "wall_time_s"} | ({*VALVE_INDICATORS} if len(self.cylinders) > 1 else set())
        keys = [key for key, (unit, _) in NUMBERS.items() if name_of(key, unit) in self.scalars and key not in left_out]
        data = {key: self[key] for key in keys}
        ledger = {term: data.pop(f"exergy_{term}_J") for term in TERMS}
        if len(self.cylinders) > 1:
            data["cylinders"] = [dict(own) for own in self.cylinders]
        return data | {
            "exergy_J_per_cycle": ledger,
            "closure": {name: self[key] for name, key in CLOSURES.items()},
            "wall_time_s": self["wall_time"],
            "warnings": list(self.warnings),
        }

    @in_house_style
    def plot(self, ax: "Axes | None" = None, what: str = "cylinder pressure") -> "Axes":
        """Draw a trace of the cycle, a line for each cylinder.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; those of a new figure if left out.
        what : {"cylinder pressure", "lift", "indicator diagram"}
            Pressure or lift over crank angle, or pressure over the cylinder volume.

        Returns
        -------
        matplotlib.axes.Axes
            Axes that were drawn on.

        Raises
        ------
        InputError
            There is no such plot.

        Examples
        --------
        >>> import apesim
        >>> run = apesim.run_engine(apesim.Machine(), speed="1000 rpm")
        >>> axes = run.plot()
        >>> axes.get_xlabel(), axes.get_ylabel()
        ('crank angle after TDC [deg]', 'cylinder pressure [MPa abs]')
        """
        from apesim.studies.drawing.panels import add_legend, add_title
        from apesim.studies.drawing.style import STYLES

        check_plotted(what, PLOTS)
        ax = axes_for(ax)
        x, y = PLOTS[what]
        lines = ax.plot(self.traces[x].values / AXES[x][0], self.traces[y].values / AXES[y][0])
        ax.set(xlabel=AXES[x][1], ylabel=AXES[y][1])
        add_title(ax, self._told_conditions())
        if len(lines) > 1:
            for number, (line, style) in enumerate(zip(lines, cycle(STYLES)), start=1):
                line.set(linestyle=style, label=f"cylinder {number}")
            add_legend(ax)
        return ax

    def plot_lift(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the lift of the intake over crank angle; see `plot`.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> import apesim
        >>> run = apesim.run_engine(apesim.Machine(), speed="1000 rpm")
        >>> axes = run.plot_lift()
        >>> round(float(max(axes.lines[0].get_ydata())), 3), axes.get_ylabel()
        (9.0, 'lift [mm]')
        """
        return self.plot(ax, "lift")

    def plot_indicator_diagram(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the cylinder pressure over the cylinder volume; see `plot`.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> import apesim
        >>> run = apesim.run_engine(apesim.Machine(), speed="1000 rpm")
        >>> run.plot_indicator_diagram().get_xlabel()
        'cylinder volume [cm³]'
        """
        return self.plot(ax, "indicator diagram")


@public
def run_engine(machine: Machine, speed: WithUnit, free: bool = False) -> EngineRun:
    """March one operating point of the engine to its periodic state.

    Parameters
    ----------
    machine : Machine
        Machine to run, of one cylinder or of several on one shaft.
    speed : str or (float, str)
        Speed of the crankshaft with its unit, "1000 rpm" or ``(1000, "rpm")``.
    free : bool
        The shaft is free: it is let go at the speed, and its own periodic state against the machine's load is found.
        Its mean speed is then a result.

    Returns
    -------
    EngineRun
        Indicators of the periodic state, and traces over a cycle.

    Raises
    ------
    InputError
        The machine or the speed is out of range.
    NotConverged
        The state does not repeat, or the march ended early; its ``result`` holds what was found.

    Examples
    --------
    >>> import apesim
    >>> run = apesim.run_engine(apesim.Machine(), speed="1000 rpm")
    >>> round(run["brake_torque"], 1), run.scalars["brake_torque"].unit
    (29.4, 'N m')
    >>> run["speed_rpm"], run["converged"]
    (1000.0, True)
    >>> run.traces["lift"]
    <Trace [m] over 721 crank_angle_deg, 0 to 0.009>
    """
    arguments, machine = arguments_of("run_engine", machine)
    omega = arguments.quantity("speed", speed, SPEED)
    arguments.refuse()

    # Compiled before the clock starts, so that the time of the call is that of computing.
    compile_point(machine, free)
    start = time.perf_counter()
    point = call_in_thread(run_point, machine, omega, is_free=free).result()
    march, values, warnings = point.run, dict(point.values), list(point.warnings.values())
    values["wall_time_s"] = time.perf_counter() - start
    done = march.status == Status.DONE
    if done and not free:
        values["speed_swing"] = _speed_swing(machine, point, omega)

    # What a reader is told beside the numbers: the conditions, and how the march ended.
    remedy = _why_it_ended(march.status, free)
    if not done:
        warnings = [f"the march ended early: {remedy}"]
    conditions = {"intake": INTAKES[machine.engine.intake]} | _shaft_conditions(machine, omega, free, values)
    orbit = march.orbit
    periodic = f"periodic after {orbit.cycles} cycles (period: {orbit.period} cycle{'s' * (orbit.period > 1)})"
    run = EngineRun(
        scalars_of(_typed(values), NUMBERS),
        _traces(point),
        conditions | supply_conditions(machine),
        warnings,
        periodic if done and orbit.converged else warnings[0],
        done and orbit.converged,
        text_writer(machine),
        cylinders=tuple(dict(own) for own in point.cylinders),
        march=march,
    )

    # The result is made before it is judged: the error carries it, so that what was found is not lost.
    if not run.converged:
        what = f"{conditions['intake']} at {conditions['speed']}"
        wrong = f"not periodic after {orbit.cycles} cycles" if done else "the march ended early"
        right = "look at the warnings of its result, and change the machine or the speed" if done else remedy
        raise NotConverged(what, wrong, right, run)
    return run


def compute_point(machine: Machine, speed: float) -> tuple[dict[str, Any], list[str]]:
    """March one operating point to its periodic state, and find its indicators and what to know of them.

    The speed is in rad/s. Returns the indicators by their names in files (NaN where the march ended early), and
    warnings, such as how the march ended early.
    """
    point = run_point(machine, speed)
    if point.run.status != Status.DONE:
        return dict(point.values), [f"the march ended early: {Status(point.run.status).remedy}"]
    return dict(point.values), list(point.warnings.values())


def _why_it_ended(status: int, free: bool) -> str:
    """What to change where a march ended early, in words."""
    if free and status == Status.STOPPED:
        return "the shaft does not finish a revolution: lower the load, or raise the speed from which it is let go"
    return Status(status).remedy


def _speed_swing(machine: Machine, point: PointRun, speed: float) -> float:
    """Estimate (highest - lowest)/mean speed of a shaft, from the torque over a turn at constant speed.

    The energy that the torque above its mean stores swings by ``J omega^2`` times as much, with the inertia J.
    """
    torque = np.sum([trace[:, TORQUE] for trace in point.traces], axis=0)[:-1]
    stored = np.cumsum(torque - torque.mean()) * TURN / len(torque)
    return float(np.ptp(stored)) / (machine.shaft.inertia * speed**2)


def _shaft_conditions(machine: Machine, speed: float, free: bool, values: Mapping[str, Any]) -> dict[str, str]:
    """Speed, and number of cylinders or stages, in words."""
    told = {"speed": f"{speed / TURN * 60.0:.6g} r/min"}
    if free:
        mean = "" if isnan(values["speed_rpm"]) else f"{values['speed_rpm']:.6g} r/min, "
        told = {"speed": f"{mean}free, let go at {told['speed']}"}
    count = int(machine.engine.cylinders)
    return told | ({"stages": "2"} if machine.stage_2.is_on else {"cylinders": str(count)} if count > 1 else {})


def supply_conditions(machine: Machine) -> dict[str, str]:
    """Write the supply of a machine in words: gauge pressure and temperature under ``supply``.

    A control pressure that the machine states stands there, too.

    >>> supply_conditions(Machine())
    {'supply': '1 MPa gauge, 287 K'}
    """
    supply, ambient = machine.supply, machine.ambient.pressure
    pressure = f"{(supply.pressure - ambient) / 1e6:.4g} MPa gauge"
    control = f"{(supply.control_pressure - ambient) / 1e6:.4g} MPa gauge"
    stated = "" if isnan(supply.control_pressure) else f" (control air {control})"
    return {"supply": f"{pressure}{stated}, {supply.temperature:.4g} K"}


def _typed(values: Mapping[str, float]) -> dict[str, float]:
    """Indicators as what they are: flags as booleans, counts as whole numbers."""
    typed = dict(values)
    typed |= {name: bool(values[name] == 1) for name in FLAGS}
    return typed | {name: int(np.nan_to_num(values[name])) for name in COUNTS}


def _traces(point: PointRun) -> dict[str, Trace]:
    """Traces of the last cycle over crank angle, by their names in Python; those of several cylinders by the shaft's.

    Of a shaft there are its speed and the torque of all cylinders, too.
    """
    dims: tuple[str, ...] = ("crank_angle_deg",)
    traces = {"crank_angle_deg": Trace(dims, point.run.angles / DEGREE, "deg", "crank angle after TDC")}
    if not isinstance(point.run, SteadyRun):
        rows = point.run.trace
        traces["speed_rpm"] = Trace(dims, rows[:, SHAFT_TRACE.index("speed [rpm]")], "r/min", "speed of the shaft")
        torque = rows[:, SHAFT_TRACE.index("gas_torque [N m]")]
        traces["gas_torque"] = Trace(dims, torque, "N m", "torque of the gas in all cylinders")
    if not point.traces:
        return traces
    rows = point.traces[0]
    if len(point.traces) > 1:
        dims, rows = (*dims, "cylinder"), np.stack(point.traces, axis=1)
        count = np.arange(1, len(point.traces) + 1)
        traces["cylinder"] = Trace(("cylinder",), count, "1", "number of the cylinder")
    for column, header in enumerate(TRACE):
        name, unit = split_header(header)
        traces[name_of(name, unit or "1")] = Trace(dims, rows[..., column], unit or "1", TRACE_NAMES[name])
    return traces


def trace_table(run: EngineRun) -> tuple[list[str], np.ndarray]:
    """Header with units and rows of a run's traces, the columns of each of several cylinders with its number."""
    rows = [run.traces["crank_angle_deg"].values]
    header = ["crank_angle [deg]"]
    if "gas_torque" in run.traces:
        rows += [run.traces["speed_rpm"].values, run.traces["gas_torque"].values]
        header += ["speed [rpm]", "gas_torque [N m]"]
    count = max(1, len(run.cylinders))
    for number in range(count):
        for column in TRACE:
            name, unit = split_header(column)
            values = run.traces[name_of(name, unit or "1")].values
            rows.append(values[:, number] if count > 1 else values)
            header.append(column if count == 1 else f"{name}_{number + 1} [{unit}]")
    return header, np.column_stack(rows)
