"""A valve or an engine that is marched in steps, its inputs changed in between."""

from numbers import Real
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.cylinder import EPV
from apesim.engine.drivetrain.control import KEYS, PRESSURES, EngineCommands, SensorReadings, command_faults
from apesim.engine.drivetrain.preparing import Course
from apesim.engine.drivetrain.state import SPEED, shaft_states
from apesim.engine.drivetrain.stepping import DrivetrainStepping, DrivetrainSteps
from apesim.engine.machine import Machine
from apesim.march.adaptive import Status
from apesim.quantities import Arguments, Fault, InputError, quoted
from apesim.quantities.arguments import WithUnit
from apesim.results import NotConverged
from apesim.studies.execution.calls import arguments_of, compile_first, public
from apesim.studies.execution.interrupts import call_uninterrupted
from apesim.studies.run.compiling import compile_drivetrain
from apesim.studies.run.operating_conditions import SPEED as OPERATING_SPEED
from apesim.studies.transient.courses import IMPOSED_SPEED, LOAD_TORQUE, START_ANGLE, commands_of
from apesim.studies.transient.transient import start_of
from apesim.valve.bench import SIZE, bench_ledger, run_bench
from apesim.valve.stepping import BenchStepping, BenchSteps

VALVE, ENGINE = "valve", "engine"
TEMPERATURES = tuple(KEYS["supply.temperature"].declaration.ends)
"""Range of the supply's temperature [K]."""
SPEEDS, LOADS = tuple(IMPOSED_SPEED.ends), tuple(LOAD_TORQUE.ends)
"""Ranges of an imposed speed [rad/s] and of a load [N m]."""
LAST = 1e9
"""Time up to which steps are marched [s]; chosen: thirty years."""
VALVE_NAMES = ("lift_m", "velocity_m_s", "pressure_a_Pa", "pressure_b_Pa", "temperature_a_K", "temperature_b_K")
"""Names of the columns of `apesim.valve.bench.TRACE`."""
SHAFT_NAMES = ("angle_deg", "speed_rpm", "gas_torque_Nm", "friction_torque_Nm", "load_torque_Nm")
"""Names of the columns of `apesim.engine.drivetrain.rates.SHAFT_TRACE`."""
WORK_NAMES = ("gas_work_J", "friction_work_J", "load_work_J")
"""Names of the works since the start: of the gas above ambient pressure, against friction and of the load."""
CYLINDER_NAMES = (
    *("cylinder_pressure_Pa", "cylinder_temperature_K", "lift_m", "velocity_m_s", "pressure_a_Pa", "pressure_b_Pa"),
    *("groove_flow_kg_s", "indicated_torque_Nm", "receiver_pressure_Pa", "exhaust_flow_kg_s", "cylinder_volume_m3"),
)
"""Names of the columns of `apesim.engine.cycle.cylinder_laws.TRACE`."""
CONTROL_AIR = int(bench_ledger(np.arange(SIZE)).supplied.mass)
"""Element of the bench's state vector that holds its control air: a vector that counts itself is read."""


class StepperSnapshot(NamedTuple):
    """State of a `Stepper` between two steps, to go back to."""

    machine: Machine
    """Machine that is stepped."""
    state: BenchSteps | DrivetrainSteps
    """All that the march needs to go on."""


class Stepper:
    """Valve or engine that is marched step by step, its inputs changed in between: for control loops and co-simulation.

    Events within a step are located, as in a run that is never left; steps of any length give the same motion within
    the tolerance of the march. A valve begins at rest, closed and released, on its bench. An engine begins as in
    `run_transient`: its shaft free and at rest at an angle, or free in the periodic state of a speed, or at an imposed
    speed.

    Parameters
    ----------
    machine : Machine
        Machine that is stepped.
    what : str
        "valve": the valve alone on its bench; "engine": all cylinders on their shaft.
    angle : str or (float, str), optional
        Angle of an engine's shaft at the start, "30 deg"; 0 deg if left out.
    from_speed : str or (float, str), optional
        Speed at whose periodic state the shaft is let free at angle 0, "1000 rpm"; at rest if left out.
    speed : str or (float, str), optional
        Speed that is imposed on the shaft from the start, "1000 rpm"; the shaft is free if left out.

    Attributes
    ----------
    machine : Machine
        Machine that is stepped.

    Raises
    ------
    InputError
        The machine or an argument is out of range, or two arguments do not go together.

    Examples
    --------
    Energised for 10 ms, the default valve opens after some 6 ms:

    >>> import apesim
    >>> stepper = apesim.Stepper(apesim.Machine(), "valve")
    >>> for step in range(1, 101):
    ...     stepper.advance(1e-4 * step, command=1)
    >>> round(1e3 * stepper.state()["lift_m"], 2)
    6.28
    """

    @public
    def __init__(
        self,
        machine: Machine,
        what: str,
        *,
        angle: WithUnit | None = None,
        from_speed: WithUnit | None = None,
        speed: WithUnit | None = None,
    ) -> None:
        arguments, self.machine = arguments_of("Stepper", machine)
        self._given = machine
        start = arguments.quantity("angle", angle, START_ANGLE)
        settled = arguments.quantity("from_speed", from_speed, OPERATING_SPEED)
        imposed = arguments.quantity("speed", speed, IMPOSED_SPEED)
        if what not in (VALVE, ENGINE):
            arguments.fault("what", f"is {quoted(what)}", f'write "{VALVE}" or "{ENGINE}"')
        given = {"angle": start, "from_speed": settled, "speed": imposed}
        _refuse_pairs(arguments, what, [name for name, value in given.items() if value is not None])
        arguments.refuse()
        self._stepping: BenchStepping | DrivetrainStepping
        if what == VALVE:
            compile_first(self.machine, run_bench, 10e-3)
            self._stepping = BenchStepping(self.machine)
        else:
            compile_drivetrain(self.machine)
            self._stepping = _engine_of(self.machine, start or 0.0, settled, imposed)

    @property
    def time(self) -> float:
        """Time that is reached [s].

        Returns
        -------
        float
            End of the last step; 0 before the first one.

        Examples
        --------
        >>> import apesim
        >>> apesim.Stepper(apesim.Machine(), "valve").time
        0.0
        """
        return self._stepping.time

    def advance(
        self,
        t: float,
        command: int | EngineCommands | None = None,
        supply: float | None = None,
        speed: float | None = None,
        *,
        temperature: float | None = None,
        load: float | None = None,
    ) -> None:
        """March to a time. Inputs hold from the end of the last step on; those that are None stay as they were.

        Parameters
        ----------
        t : float
            End of the step [s], after that of the last one.
        command : int or EngineCommands, optional
            Of a valve: 1 energises it, 0 releases it; 0 at the start. Of an engine: command angles, which each cylinder
            reads as it next passes its own 180 deg; those of the machine at the start.
        supply : float, optional
            Pressure of the supply [Pa abs]; of a valve that of its control air. An engine's control air follows unless
            the machine states its own pressure.
        speed : float, optional
            Speed of an engine's shaft [rad/s], where it is imposed.
        temperature : float, optional
            Temperature of the supply [K].
        load : float, optional
            Constant part of the load on a free shaft [N m], in place of the machine's; the rest of its load stays.

        Raises
        ------
        InputError
            The time is not after the last one, an input is out of range, or there is none such; nothing was marched.
        NotConverged
            The march ended within the step, at `time`; to go on, `restore` a snapshot, or take what the message says.

        Examples
        --------
        >>> import apesim
        >>> stepper = apesim.Stepper(apesim.Machine(), "engine", speed="600 rpm")
        >>> stepper.advance(0.05)
        >>> stepper.advance(0.1, apesim.EngineCommands(release_deg=60.0), supply=0.9e6, speed=50.0)
        >>> state = stepper.state()
        >>> round(state["angle_deg"]), round(state["speed_rad_s"])
        (323, 50)
        """
        stepping = self._stepping
        before = stepping.time
        if not (type(t) is float or _is_number(t)) or not before < t < LAST:
            _refuse("t", f"{quoted(t)}", f"give a time above {before:.9g} s, up to which it is marched")
        if supply is not None:
            _check("supply", supply, PRESSURES, "an absolute pressure", "Pa")
        if temperature is not None:
            _check("temperature", temperature, TEMPERATURES, "a temperature", "K")
        if isinstance(stepping, BenchStepping):
            if command is not None or speed is not None or load is not None:
                _check_valve(command, speed, load)
                stepping.switch(int(command))  # type: ignore[arg-type]
        elif command is not None or speed is not None or load is not None:
            self._set_engine(stepping, command, speed, load)
        if supply is not None or temperature is not None:
            stepping.feed(supply, temperature)

        outcome = call_uninterrupted(stepping.march_to, t)
        if outcome.status != Status.DONE:
            reached = f"the march ended at {stepping.time:.9g} s"
            raise NotConverged(f"the step to {t:.9g} s", reached, Status(outcome.status).remedy, None)

    def _set_engine(self, stepping: DrivetrainStepping, command: Any, speed: Any, load: Any) -> None:
        """Check the inputs that an engine alone has, then set them."""
        if command is not None:
            if not isinstance(command, EngineCommands):
                right = "give an apesim.EngineCommands, or None to keep what holds"
                _refuse("command", quoted(command), right)
            schedules = stepping.schedules or commands_of(self.machine)
            for wrong, right in command_faults(self.machine, schedules, command):
                _refuse("command", wrong, right)
        if speed is not None:
            if not stepping.is_imposed:
                right = 'leave it out, or begin with Stepper(machine, "engine", speed="1000 rpm")'
                _refuse("speed", "is given, and the shaft is free", right)
            _check("speed", speed, SPEEDS, "a speed", "rad/s")
        if load is not None:
            if stepping.is_imposed:
                right = "leave it out, or begin without a speed, with a free shaft"
                _refuse("load", "is given, and the speed is imposed", right)
            _check("load", load, LOADS, "a torque", "N m")
        if command is not None:
            stepping.command(command)
        if speed is not None:
            stepping.impose(float(speed))
        if load is not None:
            stepping.load(float(load))

    def state(self) -> dict[str, float]:
        """Return what the valve or the engine is like at the end of the last step.

        Returns
        -------
        dict of str to float
            Quantities by their names, which end with their units; pressures are absolute. Air and work are counted from
            the start. Of several cylinders, what belongs to one of them has its number at the end: ``lift_m_2``. The
            torque of the gas is above ambient pressure; ``torque_Nm`` is what friction leaves of it. NaN: the intake
            has no such quantity.

        Examples
        --------
        >>> import apesim
        >>> list(apesim.Stepper(apesim.Machine(), "valve").state())[:4]
        ['time_s', 'command', 'lift_m', 'velocity_m_s']
        """
        stepping, row = self._stepping, self._stepping.row.tolist()
        if isinstance(stepping, BenchStepping):
            own = zip(VALVE_NAMES, row, strict=True)
            state = {"time_s": stepping.time, "command": float(stepping.command), **dict(own)}
            return state | {"control_air_kg": float(stepping.y[CONTROL_AIR])}
        count, shaft = len(stepping.p.numbers), len(SHAFT_NAMES)
        state = {"time_s": stepping.time} | dict(zip(SHAFT_NAMES, row, strict=False))
        state["speed_rad_s"] = float(stepping.y[shaft_states(stepping.p) + SPEED])
        state["torque_Nm"] = state["gas_torque_Nm"] - state["friction_torque_Nm"]
        state |= zip(WORK_NAMES, stepping.works, strict=True)
        state["engine_air_kg"], state["control_air_kg"] = stepping.air
        for i in range(count):
            ending = f"_{i + 1}" if count > 1 else ""
            first = shaft + len(CYLINDER_NAMES) * i
            state |= {name + ending: row[first + j] for j, name in enumerate(CYLINDER_NAMES)}
        return state

    @property
    def readings(self) -> SensorReadings | None:
        """What an engine's sensors tell of the last whole revolution of its shaft.

        Returns
        -------
        SensorReadings or None
            Readings, as a controller of `run_transient` gets them; None before the first whole revolution, and of a
            valve.

        Examples
        --------
        >>> import apesim
        >>> stepper = apesim.Stepper(apesim.Machine(), "engine", speed="600 rpm")
        >>> stepper.advance(0.25)
        >>> stepper.readings.turns, round(stepper.readings.time_s, 6)
        (2, 0.2)
        """
        return self._stepping.readings if isinstance(self._stepping, DrivetrainStepping) else None

    def closure(self) -> dict[str, float]:
        """Return what all steps so far do not account for.

        Returns
        -------
        dict of str to float
            Mass and energy of the air, relative to what was turned over; of a free shaft its energy, too.

        Examples
        --------
        >>> import apesim
        >>> stepper = apesim.Stepper(apesim.Machine(), "valve")
        >>> stepper.advance(0.05, command=1)
        >>> max(stepper.closure().values()) < 1e-12
        True
        """
        return self._stepping.closure()

    def snapshot(self) -> StepperSnapshot:
        """Copy the state of the moment, to go back to.

        Returns
        -------
        StepperSnapshot
            Copy that no later step changes.

        Examples
        --------
        >>> import apesim
        >>> stepper = apesim.Stepper(apesim.Machine(), "valve")
        >>> start = stepper.snapshot()
        >>> stepper.advance(0.02, command=1)
        >>> stepper.restore(start)
        >>> stepper.time
        0.0
        """
        return StepperSnapshot(self._given, self._stepping.copy_all())

    def restore(self, snapshot: StepperSnapshot) -> None:
        """Go back to a state: the same steps from there on give the same bits.

        Parameters
        ----------
        snapshot : StepperSnapshot
            What `snapshot` has copied, of this stepper or of another one of the same machine.

        Raises
        ------
        InputError
            The snapshot is of another machine, or of the other kind of stepper.

        Examples
        --------
        >>> import apesim
        >>> stepper = apesim.Stepper(apesim.Machine(), "valve")
        >>> stepper.advance(5e-3, command=1)
        >>> kept, lifts = stepper.snapshot(), []
        >>> for _ in range(2):
        ...     stepper.restore(kept)
        ...     stepper.advance(8e-3)
        ...     lifts.append(stepper.state()["lift_m"])
        >>> lifts[0] == lifts[1]
        True
        """
        stepping = self._stepping
        state = snapshot.state if isinstance(snapshot, StepperSnapshot) else None
        kind = BenchSteps if isinstance(stepping, BenchStepping) else DrivetrainSteps
        is_same = isinstance(state, kind) and snapshot.machine is self._given
        if isinstance(state, DrivetrainSteps) and isinstance(stepping, DrivetrainStepping):
            is_same = is_same and state.is_imposed == stepping.is_imposed
        if not is_same:
            right = "give what snapshot() of this stepper returned, or of another one of the same machine"
            raise InputError([Fault("Stepper.restore()", "snapshot", "is of something else", right)])
        stepping.restore(state)  # type: ignore[arg-type]  # of the same kind

    def __repr__(self) -> str:
        what = VALVE if isinstance(self._stepping, BenchStepping) else ENGINE
        return f"<Stepper: {what} at {self.time:g} s>"


def _refuse_pairs(arguments: Arguments, what: str, given: list[str]) -> None:
    """Note a fault where two arguments do not go together."""
    if what == VALVE:
        for name in given:
            arguments.fault(name, "is given, and a valve on its bench has no shaft", "leave it out")
    if "from_speed" in given:
        for name in given:
            if name != "from_speed":
                arguments.fault(name, "does not go with `from_speed`", "leave one of them out")


def _engine_of(machine: Machine, angle: float, from_speed: float | None, speed: float | None) -> DrivetrainStepping:
    """Prepare an engine at an angle [rad], at rest, in its periodic state at a speed [rad/s] or at an imposed one."""
    schedules = commands_of(machine) if machine.engine.intake == EPV else []
    speeds = np.empty((0, 2)) if speed is None else np.array([[0.0, speed], [1.0, speed]])
    return DrivetrainStepping(
        machine, start_of(machine, angle, from_speed, Course(speeds, schedules=schedules)), schedules
    )


def _is_number(value: Any) -> bool:
    """Whether a value is a real number, and no truth value."""
    return isinstance(value, Real) and not isinstance(value, bool)


def _check(name: str, value: Any, ends: tuple[float, ...], kind: str, unit: str) -> None:
    """Refuse an input that is no number within its range."""
    low, high = ends
    if not _is_number(value) or not low <= value <= high:
        _refuse(name, quoted(value), f"give {kind} from {low:g} to {high:g} {unit}, or None to keep what holds")


def _check_valve(command: Any, speed: Any, load: Any) -> None:
    """Refuse inputs that a valve on its bench does not have, and a command that is neither 1 nor 0."""
    for name, value in (("speed", speed), ("load", load)):
        if value is not None:
            _refuse(name, "is given, and a valve on its bench has no shaft", "leave it out")
    if not isinstance(command, Real) or command not in (0, 1):
        _refuse("command", quoted(command), "give 1 to energise the valve, 0 to release it, or None")


def _refuse(name: str, wrong: str, right: str) -> None:
    """Refuse an argument of a step."""
    raise InputError([Fault("Stepper.advance()", name, wrong, right)])
