"""One run of the valve on its bench, as a result."""

import time
from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING, Any, ClassVar

from apesim.engine.machine import Machine
from apesim.march.adaptive import TOLERANCE, Status
from apesim.quantities import split_header
from apesim.quantities.arguments import Given
from apesim.results import NotConverged, Result, Trace, scalars_of
from apesim.studies.drawing.axes import axes_for, check_plotted, in_house_style
from apesim.studies.execution.calls import arguments_of, compile_first, public, text_writer
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.run.engine_run import supply_conditions
from apesim.studies.run.operating_conditions import PRESSURE, RATE, TEMPERATURE, TIME, with_control_air
from apesim.valve.bench import TRACE, BenchRun, run_bench
from apesim.valve.warnings import judge_bench

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STROKES = ("opening", "closing")
MEASURES = {
    "delay_s": ("s", "delay time: command edge to 1 % of the stroke"),
    "stroke_time_s": ("s", "full stroke time: from there to contact"),
    "seating_speed_m_s": ("m/s", "seating speed: speed just before contact"),
    "fluctuation": ("1", "(peak speed - lowest later speed before contact)/peak"),
    "reverses": ("1", "whether the motion turns back before contact"),
}
"""Measures of a stroke by their keys in JSON: unit and what they are."""
CLOSURES = {
    "mass": "mass not accounted for, relative to what was supplied",
    "energy": "energy not accounted for, relative to what was supplied",
    "work": "work on the piston by quadrature of the dense output against the ledger, relative",
}
NUMBERS = {
    **{f"{stroke}_{key}": (unit, f"{text}, {stroke}") for stroke in STROKES for key, (unit, text) in MEASURES.items()},
    "control_air_kg": ("kg", "control air through the supply sides of both solenoids"),
    **{f"{name}_closure": ("1", text) for name, text in CLOSURES.items()},
    "tolerance": ("1", "of a step"),
    "wall_time_s": ("s", "computing time of the call"),
}
OF_ORBIT = {
    "converged": ("1", "whether the state repeats"),
    "period_cycles": ("1", "cycles after which the state repeats; 0: not seen to repeat"),
    "cycles": ("1", "cycles marched to the periodic state"),
}
"""Numbers of a repeated pulse."""
TRACE_NAMES = {
    "lift": "lift",
    "velocity": "velocity of the lift, positive as the valve opens",
    "pressure_a": "pressure of chamber A, which pushes to closed",
    "pressure_b": "pressure of chamber B, which pushes to open",
    "temperature_a": "temperature of chamber A",
    "temperature_b": "temperature of chamber B",
}
PLOTS: dict[str, tuple[str, float, dict[str, tuple[str | None, str]]]] = {
    "lift": ("lift [mm]", 1e-3, {"lift": (None, "-")}),
    "pressures": ("pressure [MPa abs]", 1e6, {"pressure_a": ("chamber A", "-"), "pressure_b": ("chamber B", "--")}),
}
"""What a run draws: label of the axis, its unit in SI, and traces with their labels and styles of lines."""


@dataclass(frozen=True, eq=False, repr=False)
class ValveRun(Result):
    """One bench run; numbers as ``apesim valve run --json`` has them, traces as its CSV.

    A measure of a stroke has the stroke before its name: ``opening_delay``, ``closing_seating_speed``.

    Attributes
    ----------
    march : BenchRun
        March of the bench, for those who look deeper.
    """

    title: ClassVar[str] = "one bench run of the valve"
    headline: ClassVar[tuple[str, ...]] = (
        "opening_delay",
        "opening_stroke_time",
        "opening_seating_speed",
        "closing_delay",
        "closing_stroke_time",
        "closing_seating_speed",
    )

    march: BenchRun = field(kw_only=True)

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary with the keys of ``apesim valve run --json``.

        Returns
        -------
        dict
            Measures of both strokes, control air, closures and warnings; NaN where JSON says null.

        Examples
        --------
        >>> import apesim
        >>> run = apesim.run_valve(apesim.Machine(), supply="0.49 MPa gauge")
        >>> data = run.to_dict()
        >>> round(1e3 * data["opening"]["stroke_time_s"], 2), sorted(data["closure"])
        (7.14, ['energy', 'mass', 'work'])
        """
        return {
            **{stroke: {key: self[f"{stroke}_{key}"] for key in MEASURES} for stroke in STROKES},
            "control_air_kg": self["control_air"],
            "closure": {name: self[f"{name}_closure"] for name in CLOSURES},
            "tolerance": self["tolerance"],
            **{key: self.get(key) for key in OF_ORBIT},
            "wall_time_s": self["wall_time"],
            "warnings": list(self.warnings),
        }

    @in_house_style
    def plot(self, ax: "Axes | None" = None, what: str = "lift") -> "Axes":
        """Draw traces over time.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; those of a new figure if left out.
        what : {"lift", "pressures"}
            Lift, or the pressures of both chambers.

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
        >>> run = apesim.run_valve(apesim.Machine(), supply="0.49 MPa gauge")
        >>> axes = run.plot()
        >>> axes.get_xlabel(), axes.get_ylabel()
        ('time after the solenoids are energised [ms]', 'lift [mm]')
        """
        from apesim.studies.drawing.panels import add_legend, add_title

        check_plotted(what, PLOTS)
        ax = axes_for(ax)
        ylabel, unit, drawn = PLOTS[what]
        for name, (label, style) in drawn.items():
            ax.plot(self.traces["time"].values / 1e-3, self.traces[name].values / unit, ls=style, label=label)
        ax.set(xlabel="time after the solenoids are energised [ms]", ylabel=ylabel)
        add_title(ax, self._told_conditions())
        if len(drawn) > 1:
            add_legend(ax)
        return ax

    def plot_pressures(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the pressures of both chambers over time; see `plot`.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> import apesim
        >>> run = apesim.run_valve(apesim.Machine(), supply="0.49 MPa gauge")
        >>> axes = run.plot_pressures()
        >>> [line.get_label() for line in axes.lines]
        ['chamber A', 'chamber B']
        """
        return self.plot(ax, "pressures")


@public
def run_valve(
    machine: Machine,
    *,
    supply: Given | None = None,
    temperature: Given | None = None,
    pulse: Given = "50 ms",
    until: Given | None = None,
    repeat: Given | None = None,
) -> ValveRun:
    """Run the valve alone on its bench: a single pulse from rest, or a repeated one at its periodic state.

    Parameters
    ----------
    machine : Machine
        Machine with the valve.
    supply : str or float, optional
        Pressure of the control air, e.g. "0.49 MPa gauge", or [Pa abs]; the machine's if left out.
    temperature : str or float, optional
        Temperature of the control air, e.g. "287 K", or [K]; the machine's if left out.
    pulse : str or float
        Time for which the solenoids are energised, e.g. "50 ms", or [s].
    until : str or float, optional
        End of a single run [s]; twice the pulse if left out.
    repeat : str or float, optional
        Rate at which the pulse is repeated, e.g. "20 Hz", or [Hz].

    Returns
    -------
    ValveRun
        Measures of both strokes, and traces over time.

    Raises
    ------
    InputError
        The machine or an argument is out of range, or two arguments do not go together.
    NotConverged
        The motion does not repeat, or the march ended early; its ``result`` holds what was found.

    Examples
    --------
    >>> import apesim
    >>> run = apesim.run_valve(apesim.Machine(), supply="0.49 MPa gauge")
    >>> round(1e3 * run["opening_delay"], 2), run.scalars["opening_delay"].unit
    (5.66, 's')
    >>> run.traces["lift"]
    <Trace [m] over 1001 time, 0 to 0.009>
    """
    arguments, machine = arguments_of("run_valve", machine)
    pressure = arguments.quantity("supply", supply, PRESSURE)
    kelvin = arguments.quantity("temperature", temperature, TEMPERATURE)
    seconds = arguments.quantity("pulse", pulse, TIME)
    end = arguments.quantity("until", until, TIME)
    rate = arguments.quantity("repeat", repeat, RATE)

    # Arguments that are right each by itself, but do not go together.
    period = inf if rate is None else 1.0 / rate
    if rate is not None and end is not None:
        arguments.fault("until", "does not go with `repeat`", "leave one of them out")
    if seconds is not None and seconds >= period:
        right = f"less than the period, {period * 1e3:g} ms"
        arguments.fault("pulse", "is longer than the period of `repeat`", right)
    arguments.refuse()
    machine = with_control_air(machine, pressure, kelvin)

    # Compiled before the clock starts, so that the time of the call is that of computing.
    compile_first(machine, run_bench, 10e-3)
    start = time.perf_counter()
    march = call_in_thread(run_bench, machine, seconds, end, period).result()
    wall_time = time.perf_counter() - start

    # How it ended, in words. A single pulse has nothing to repeat, so that it is neither periodic nor not.
    done, orbit = march.status == Status.DONE, march.orbit
    remedy = Status(march.status).remedy
    warnings = list(judge_bench(march).values()) if done else [f"the march ended early: {remedy}"]
    conditions = {"pulse": f"{1e3 * seconds:g} ms"}
    if rate is not None:
        conditions["repeated at"] = f"{rate:g} Hz"
    converged = done and orbit.converged if orbit else None if done else False
    ending = ""
    if orbit and converged:
        ending = f"periodic after {orbit.cycles} cycles (period: {orbit.period} cycle{'s' * (orbit.period > 1)})"
    elif converged is False:
        ending = warnings[0]
    run = ValveRun(
        scalars_of(_values(march, wall_time), NUMBERS | OF_ORBIT),
        _traces(march),
        conditions | supply_conditions(machine),
        warnings,
        ending,
        converged,
        text_writer(machine),
        march=march,
    )

    # The result is made before it is judged: the error carries it, so that what was found is not lost.
    if converged is False:
        wrong = f"not periodic after {orbit.cycles} cycles" if done and orbit else "the march ended early"
        right = "change the pulse, the rate or the supply" if done else remedy
        raise NotConverged(f"a pulse of {conditions['pulse']}", wrong, right, run)
    return run


def _values(march: BenchRun, wall_time: float) -> dict[str, Any]:
    """Numbers of a run by their keys in JSON, see `NUMBERS` and `OF_ORBIT`."""
    values: dict[str, Any] = {}
    for stroke in STROKES:
        measured = getattr(march, stroke)
        values |= {
            f"{stroke}_delay_s": measured.delay,
            f"{stroke}_stroke_time_s": measured.stroke_time,
            f"{stroke}_seating_speed_m_s": measured.seating_speed,
            f"{stroke}_fluctuation": measured.fluctuation,
            f"{stroke}_reverses": measured.reverses,
        }
    values["control_air_kg"] = march.control_air
    values |= {f"{name}_closure": march.closure[name] for name in CLOSURES}
    values |= {"tolerance": TOLERANCE, "wall_time_s": wall_time}
    if march.orbit:
        orbit: Any = march.orbit
        values |= {"converged": orbit.converged, "period_cycles": orbit.period, "cycles": orbit.cycles}
    return values


def _traces(march: BenchRun) -> dict[str, Trace]:
    """Traces of a run over time, by their names in Python."""
    dims = ("time",)
    traces = {"time": Trace(dims, march.times, "s", "time after the solenoids are energised")}
    for column, header in enumerate(TRACE):
        name, unit = split_header(header)
        traces[name] = Trace(dims, march.trace[:, column], unit or "1", TRACE_NAMES[name])
    return traces
