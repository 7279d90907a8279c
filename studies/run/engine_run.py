"""One operating point of the engine at its periodic state, as a result."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isnan, nan
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cylinder import INTAKES
from apesim.engine.exergy import TERMS
from apesim.engine.indicators import COUNTS, FLAGS, INDICATORS, indicators
from apesim.engine.machine import Machine
from apesim.engine.steady import SteadyRun, run_steady
from apesim.engine.warnings import judge_point
from apesim.march.adaptive import Status
from apesim.quantities import split_header
from apesim.quantities.arguments import WithUnit
from apesim.results import NotConverged, Result, Trace, name_of, scalars_of
from apesim.studies.execution.calls import arguments_of, compile_first, public, text_writer
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.run.operating_conditions import SPEED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

QUICK = 100.0
"""Speed of a march that only compiles [rad/s]: a cycle of a slow machine can take seconds of computing."""
CLOSURES = {
    "mass": "mass_closure",
    "energy": "energy_closure",
    "exergy": "exergy_closure",
    "work_by_quadrature": "work_by_quadrature_change",
    "work_at_tenfold_tolerance": "work_tolerance_change",
    "air_at_tenfold_tolerance": "air_tolerance_change",
}
"""How closely a cycle closes: the key in JSON, and the name of the indicator."""
NUMBERS = INDICATORS | {"wall_time_s": ("s", "computing time of the call")}
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
PLOTS = {
    "cylinder pressure": ("crank_angle_deg", "cylinder_pressure"),
    "lift": ("crank_angle_deg", "lift"),
    "indicator diagram": ("cylinder_volume", "cylinder_pressure"),
}
"""What a run draws: traces of both axes."""


@dataclass(frozen=True, eq=False, repr=False)
class EngineRun(Result):
    """One operating point at its periodic state; numbers as ``apesim engine run --json`` has them, traces as its CSV.

    Attributes
    ----------
    march : SteadyRun
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

    march: SteadyRun = field(kw_only=True)

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary with the keys of ``apesim engine run --json``.

        Returns
        -------
        dict
            Indicators, exergy of a cycle, closures and warnings; NaN where JSON says null.

        Examples
        --------
        >>> import apesim
        >>> run = apesim.run_engine(apesim.Machine(), speed="1000 rpm")
        >>> data = run.to_dict()
        >>> data["speed_rpm"], sorted(data["closure"])[:3]
        (1000.0, ['air_at_tenfold_tolerance', 'energy', 'exergy'])
        """
        data = {key: self[key] for key in INDICATORS if key not in CLOSURES.values()}
        ledger = {term: data.pop(f"exergy_{term}_J") for term in TERMS}
        return data | {
            "exergy_J_per_cycle": ledger,
            "closure": {name: self[key] for name, key in CLOSURES.items()},
            "wall_time_s": self["wall_time"],
            "warnings": list(self.warnings),
        }

    def plot(self, ax: "Axes | None" = None, what: str = "cylinder pressure") -> "Axes":
        """Draw a trace of the cycle.

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
        from apesim.studies.drawing.axes import axes_for, check_plotted

        check_plotted(what, PLOTS)
        ax = axes_for(ax)
        x, y = PLOTS[what]
        ax.plot(self.traces[x].values / AXES[x][0], self.traces[y].values / AXES[y][0])
        ax.set(xlabel=AXES[x][1], ylabel=AXES[y][1], title=self._told_conditions())
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
def run_engine(machine: Machine, speed: WithUnit) -> EngineRun:
    """March one operating point of the engine to its periodic state.

    Parameters
    ----------
    machine : Machine
        Machine to run.
    speed : str or (float, str)
        Speed of the crankshaft with its unit, "1000 rpm" or ``(1000, "rpm")``.

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
    compile_first(machine, run_steady, QUICK, max_cycles=1)
    start = time.perf_counter()
    march, values, warnings = call_in_thread(compute_point, machine, omega).result()
    values["wall_time_s"] = time.perf_counter() - start

    # What a reader is told beside the numbers: the conditions, and how the march ended.
    done, remedy = march.status == Status.DONE, Status(march.status).remedy
    conditions = {"intake": INTAKES[machine.engine.intake], "speed": f"{omega / TURN * 60.0:.6g} r/min"}
    orbit = march.orbit
    periodic = f"periodic after {orbit.cycles} cycles (period: {orbit.period} cycle{'s' * (orbit.period > 1)})"
    run = EngineRun(
        scalars_of(_typed(values), NUMBERS),
        _traces(march),
        conditions | supply_conditions(machine),
        warnings,
        periodic if done and orbit.converged else warnings[0],
        done and orbit.converged,
        text_writer(machine),
        march=march,
    )

    # The result is made before it is judged: the error carries it, so that what was found is not lost.
    if not run.converged:
        what = f"{conditions['intake']} at {conditions['speed']}"
        wrong = f"not periodic after {orbit.cycles} cycles" if done else "the march ended early"
        right = "look at the warnings of its result, and change the machine or the speed" if done else remedy
        raise NotConverged(what, wrong, right, run)
    return run


def compute_point(machine: Machine, speed: float) -> tuple[SteadyRun, dict[str, Any], list[str]]:
    """March one operating point to its periodic state, and find its indicators and what to know of them.

    The speed is in rad/s. Returns the last cycle, the indicators by their names in files (NaN where the march ended
    early), and warnings, such as how the march ended early.
    """
    march = run_steady(machine, speed)
    if march.status != Status.DONE:
        return march, dict.fromkeys(INDICATORS, nan), [f"the march ended early: {Status(march.status).remedy}"]
    values = indicators(machine, march)
    return march, values, list(judge_point(machine, march, values).values())


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


def _traces(march: SteadyRun) -> dict[str, Trace]:
    """Traces of the last cycle over crank angle, by their names in Python."""
    dims = ("crank_angle_deg",)
    traces = {"crank_angle_deg": Trace(dims, march.angles / DEGREE, "deg", "crank angle after TDC")}
    for column, header in enumerate(TRACE):
        name, unit = split_header(header)
        traces[name_of(name, unit or "1")] = Trace(dims, march.trace[:, column], unit or "1", TRACE_NAMES[name])
    return traces
