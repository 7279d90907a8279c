"""Prediction: what a machine would have shown the sensors of a measured run."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from math import isnan, nan
from typing import Any, NamedTuple

import numpy as np

from apesim.effect import sensed
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.cylinder_laws import TRACE as ENGINE_TRACE
from apesim.engine.cycle.state import Cycle, control_ledger, engine_ledger
from apesim.engine.cylinder import EPV
from apesim.engine.effects import library_of
from apesim.engine.indicators import friction_pressure, peak_pressure, valve_angles, valve_motion
from apesim.engine.kinematics import swept_volume
from apesim.engine.machine import Machine
from apesim.engine.steady import SteadyRun, known_state, run_steady
from apesim.march.adaptive import TOLERANCE, Status
from apesim.march.periodic import Known
from apesim.reading import Reading
from apesim.studies.measured.runs import CYLINDER, ENGINE, VALVE, MeasuredRun
from apesim.valve.bench import TRACE as VALVE_TRACE
from apesim.valve.bench import run_bench, trace_bench
from apesim.valve.rig import drive_force

VALVE_COLUMNS, ENGINE_COLUMNS = (
    {header.split(" [")[0]: column for column, header in enumerate(trace)} for trace in (VALVE_TRACE, ENGINE_TRACE)
)
"""Columns of the traces by name of the quantity."""
MEANS = ("torque", "air_flow")
"""Sensors of an engine that give means."""
NEARLY_PERIODIC = 1e-7
"""Largest relative distance from the periodic state: on pressures a thousandth of a usual sensor's noise at most."""
NEVER = {"opening_start": nan, "opening_contact": nan, "closing_start": nan, "closing_contact": nan}
"""Marks of strokes that never come."""

Marks = dict[str, float]
"""Times by which the model divides a run, see `Prediction.marks`."""
Memory = dict[bytes, tuple[dict[str, Any], bool, Callable[[], Marks], Known | None]]
"""What ideal sensors see of one run: channels, failure, and what finds the marks, by the bytes of the instants asked
for."""


class Prediction(NamedTuple):
    """A run as its sensors would have shown it."""

    channels: dict[str, np.ndarray]
    """(n,) float arrays at the times of the run, SI, by sensor; NaN where the simulation failed."""
    means: dict[str, float]
    """Means, SI, by sensor."""
    find_marks: Callable[[], Marks]
    """Finds the `marks`, which few ask for: a valve is marched once more for them."""
    failed: bool
    """Whether the march ended early, or has not become periodic."""
    start: Known | None = None
    """Start for the next machine, where this one was marched from one; see `predict`."""

    @property
    def marks(self) -> Marks:
        """Times since the energising by which the model divides the run [s]; NaN: never.

        ``energise``, ``release``; ``opening_start`` and ``closing_start``, with 1 % of the stroke done;
        ``opening_contact`` and ``closing_contact``, the first with the far stop. An engine has ``groove_opens``,
        ``groove_closes``, ``exhaust_opens`` and ``exhaust_closes``, too; what the valve does in the next cycle is later
        than a period.
        """
        return self.find_marks()


def with_value(tree: Any, key: str, value: object) -> Any:
    """A copy of a machine, or of a part of one, with another value [SI] at one dotted key, e.g. "valve.stroke"."""
    name, _, rest = key.partition(".")
    return tree._replace(**{name: with_value(getattr(tree, name), rest, value) if rest else value})


def with_values(tree: Any, values: Mapping[str, object]) -> Any:
    """A copy of a machine, or of a part of one, with other values [SI] at several dotted keys, e.g. "valve.stroke".

    Each part is copied once, however many of its numbers change.
    """
    parts: dict[str, dict[str, object]] = {}
    own: dict[str, Any] = {}
    for key, value in values.items():
        name, _, rest = key.partition(".")
        if rest:
            parts.setdefault(name, {})[rest] = value
        else:
            own[name] = value
    for name, inner in parts.items():
        own[name] = with_values(getattr(tree, name), inner)
    return tree._replace(**own) if own else tree


def run_of(machine: Machine, run: MeasuredRun) -> Machine:
    """Take the supply of a measured run, and an engine's command, into a copy of a machine.

    On a valve's bench the supply is that of the control air. On an engine the control air is as the run states it, else
    as the machine does. What the run states of its supply is freed of the errors of gauge and thermometer that the
    machine knows of.
    """
    effects: Any = machine.effects
    gain, offset = effects.sensor_gain.supply_pressure, effects.sensor_offset.supply_temperature
    ambient = machine.ambient.pressure
    pressure = ambient + (run.supply - ambient) / (1.0 + gain) if gain else run.supply
    control = nan if run.bench == VALVE else machine.supply.control_pressure
    supply = machine.supply._replace(
        pressure=pressure, control_pressure=control if isnan(run.control_supply) else run.control_supply
    )
    if not isnan(run.temperature):
        supply = supply._replace(temperature=run.temperature - offset)
    if run.bench == ENGINE:
        machine = machine._replace(command=machine.command._replace(energise=run.energise, release=run.release))
    return machine._replace(supply=supply)


def start_of(machine: Machine, run: MeasuredRun) -> Known | None:
    """Find the state from which the predictions of machines that differ a little start, see `predict`.

    `machine` has the supply and the command of the run, see `run_of`. The state is that of an engine that settles to
    every cycle alike; None for another, and on a valve's bench, which starts from rest.
    """
    return known_state(machine, run.speed) if run.bench == ENGINE else None


def predict(
    machine: Machine,
    run: MeasuredRun,
    sensors: Iterable[str] | None = None,
    start: Known | None = None,
    tolerance: float = TOLERANCE,
    memory: Memory | None = None,
) -> Prediction:
    """Predict what the sensors would have shown of a measured run, the effects of the slot ``sensor`` applied.

    `machine` has the supply and the command of the run, see `run_of`; `sensors` are those of the run if left out.
    `start` is the state from `start_of` for this run with a machine a little different: the outcome is the same, and
    comes sooner. `tolerance` is the relative tolerance of the march. `memory` keeps what ideal sensors see of this run,
    by the instants asked for: it is filled here, and read before anything is marched; hand it again only with machines
    that differ in effects of the slot ``sensor`` alone.

    >>> times = np.array([0.0, 25e-3])
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 30e-3, "fit", times, {"lift": np.zeros(2)})
    >>> lift = predict(run_of(Machine(), run), run).channels["lift"]
    >>> (1e3 * lift).round(2)
    array([0., 9.])
    """
    names = [*run.channels, *run.means] if sensors is None else list(sensors)
    simulated = BENCH_RUNS[run.bench](machine, run, names, start, tolerance)
    remembered = _Remembered(simulated, {} if memory is None else memory)
    reading = sensed(library_of(machine.effects), machine.effects, Reading(remembered, run.speed, run.energise))
    shown = reading.at(run.times)
    means = {name: float(shown.pop(name)) for name in MEANS if name in shown}
    return Prediction(shown, means, remembered.find_marks, remembered.failed, remembered.start)


class _Remembered:
    """A run that is marched once for the same instants."""

    def __init__(self, simulated: "_ValveRun | _EngineRun | _CylinderRun", memory: Memory) -> None:
        self.simulated, self.memory = simulated, memory
        self.find_marks: Callable[[], Marks] = dict
        self.failed = False
        self.start: Known | None = None

    def __call__(self, times: np.ndarray) -> dict[str, Any]:
        """Channels, (n,) arrays by sensor, at times since the energising [s]."""
        key = times.tobytes()
        if key not in self.memory:
            shown, simulated = self.simulated(times), self.simulated
            self.memory[key] = shown, simulated.failed, simulated.find_marks, simulated.known
        shown, self.failed, self.find_marks, self.start = self.memory[key]
        return dict(shown)


class _ValveRun:
    """A run of the valve's bench as ideal sensors see it; marched when it is asked for its channels."""

    def __init__(
        self, machine: Machine, run: MeasuredRun, sensors: Sequence[str], start: Known | None, tolerance: float
    ) -> None:
        self.machine, self.run, self.sensors, self.tolerance = machine, run, sensors, tolerance
        self.find_marks: Callable[[], Marks] = dict
        self.failed = False
        self.known: Known | None = None

    def __call__(self, times: np.ndarray) -> dict[str, Any]:
        """Channels, (n,) arrays by sensor; before the energising all rests."""
        times = np.maximum(times, 0.0)
        trace, status = trace_bench(self.machine, self.run.pulse, times, self.tolerance)
        self.find_marks = partial(_valve_marks, self.machine, self.run.pulse, float(times[-1]), self.tolerance)
        self.failed = status != Status.DONE
        return _shown(self.sensors, VALVE_COLUMNS, trace, self.failed)


class _EngineRun:
    """A periodic cycle of the engine as ideal sensors see it; marched when it is asked for its channels."""

    def __init__(
        self, machine: Machine, run: MeasuredRun, sensors: Sequence[str], start: Known | None, tolerance: float
    ) -> None:
        self.machine, self.run, self.sensors, self.start, self.tolerance = machine, run, sensors, start, tolerance
        self.find_marks: Callable[[], Marks] = dict
        self.failed = False
        self.known: Known | None = None

    def __call__(self, times: np.ndarray) -> dict[str, Any]:
        """Channels, (n,) arrays by sensor, and means; every turn is like the other."""
        # Instants of any turn, brought into one and sorted: the rows of a march ascend within a turn.
        speed = self.run.speed
        period = TURN / speed
        times = times % period
        order = np.argsort(times)
        angles = self.machine.command.energise + speed * times[order]
        run = run_steady(
            self.machine,
            speed,
            self.tolerance,
            periodic_tolerance=NEARLY_PERIODIC,
            angles=angles,
            start=self.start,
            estimate_error=False,
        )

        # What the sensors see, back in the order of the instants; means stay NaN where the march has failed.
        self.failed = run.status != Status.DONE or not run.orbit.converged
        self.known = run.orbit.known
        trace = np.empty_like(run.trace)
        trace[order] = run.trace
        traces = [sensor for sensor in self.sensors if sensor not in MEANS]
        shown = _shown(traces, ENGINE_COLUMNS, trace, self.failed) | dict.fromkeys(set(self.sensors) & set(MEANS), nan)

        # The marks are found when they are asked for; a failed march has none.
        self.find_marks = partial(dict, dict.fromkeys(("energise", *NEVER), nan))
        if not self.failed:
            self.find_marks = partial(_engine_marks, self.machine, run)

        # The means are of the whole cycle, which the ledgers know; the rows of the trace may be few.
        if not self.failed and len(shown) > len(traces):
            control, engine = control_ledger(run.end), engine_ledger(run.end)
            brake = engine.work - friction_pressure(run, peak_pressure(run)) * swept_volume(run.cycle.engine)
            means = {"torque": brake / TURN, "air_flow": (engine.groove.mass + control.supplied.mass) / period}
            shown |= {name: means[name] for name in MEANS if name in shown}
        return shown


class _CylinderRun:
    """A way to and fro of a cylinder as ideal sensors see it."""

    def __init__(
        self, machine: Machine, run: MeasuredRun, sensors: Sequence[str], start: Known | None, tolerance: float
    ) -> None:
        self.machine, self.run, self.sensors = machine, run, sensors
        self.find_marks: Callable[[], Marks] = partial(dict, {"energise": 0.0, "release": nan} | NEVER)
        self.failed = False
        self.known: Known | None = None

    def __call__(self, times: np.ndarray) -> dict[str, Any]:
        """Channels, (n,) arrays by sensor, with what is given taken linear between its times."""
        stroke, pressure, velocity = (
            np.interp(times, self.run.times, self.run.given[name]) for name in ("stroke", "pressure", "velocity")
        )
        force = drive_force(self.machine, stroke, pressure, velocity)
        return dict.fromkeys(self.sensors, force)


BENCH_RUNS: dict[str, type[_ValveRun] | type[_EngineRun] | type[_CylinderRun]] = {
    VALVE: _ValveRun,
    ENGINE: _EngineRun,
    CYLINDER: _CylinderRun,
}
"""How a run of each bench is simulated."""


def _shown(sensors: Iterable[str], columns: Mapping[str, int], trace: np.ndarray, failed: bool) -> dict[str, Any]:
    """Channels of a trace, by sensor."""
    return {sensor: np.full(len(trace), nan) if failed else trace[:, columns[sensor]] for sensor in sensors}


def _marks(opening: Any, closing: Any, release: float) -> dict[str, float]:
    """Starts and contacts of both strokes, each an `apesim.valve.measures.Stroke` [s]."""
    return dict(
        zip(NEVER, (opening.delay, opening.contact, release + closing.delay, closing.contact), strict=True),
    )


def _valve_marks(machine: Machine, pulse: float, until: float, tolerance: float) -> Marks:
    """Marks of a single pulse, see `Prediction.marks`."""
    bench = run_bench(machine, pulse, until, tolerance=tolerance)
    return {"energise": 0.0, "release": pulse} | _marks(bench.opening, bench.closing, pulse)


def _engine_marks(machine: Machine, run: SteadyRun) -> dict[str, float]:
    """Marks of a periodic cycle, see `Prediction.marks`."""
    p, command = run.cycle, machine.command
    release = (command.release - command.energise) / p.speed
    if p.engine.intake == EPV:
        opening, closing, opens, closes = valve_motion(machine, run)
        marks = _marks(opening, closing, release) | {"groove_opens": opens, "groove_closes": closes}
    else:
        angles = valve_angles(machine, run)
        named = {
            "opening_contact": "full_open_deg",
            "closing_contact": "closed_deg",
            "groove_opens": "valve_open_deg",
            "groove_closes": "valve_close_deg",
        }
        marks = NEVER | {mark: (angles[name] * DEGREE - p.start) / p.speed for mark, name in named.items()}
    return {"energise": 0.0, "release": release} | marks | exhaust_marks(p)


def exhaust_marks(p: Cycle) -> dict[str, float]:
    """Marks of the exhaust, which lasts from the first valve's opening to the last one's closing."""
    near = 0.5 * TURN - p.exhausts[0].opens
    first = min(p.exhausts, key=lambda valve: (valve.opens + near) % TURN)
    last = max(p.exhausts, key=lambda valve: (valve.closes - first.opens) % TURN)
    return {
        "exhaust_opens": (first.opens - p.start) % TURN / p.speed,
        "exhaust_closes": (last.closes - p.start) % TURN / p.speed,
    }
