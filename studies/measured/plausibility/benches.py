"""All checks of a run against the machine: a table of rows for each bench, in the order in which they are made."""

from apesim.engine.machine import Machine
from apesim.studies.measured.plausibility.cylinder_bench import judge_force, judge_given_pressure
from apesim.studies.measured.plausibility.engine_bench import (
    judge_air_flow,
    judge_crank_angle,
    judge_torque,
    judge_turn,
)
from apesim.studies.measured.plausibility.expected import NOTHING_SHOWN, Expected, expect
from apesim.studies.measured.plausibility.findings import Check, Finding, Kind
from apesim.studies.measured.plausibility.levels import (
    judge_lift,
    judge_pressure,
    judge_supply,
    judge_supply_temperature,
    judge_temperature,
    judge_velocity,
)
from apesim.studies.measured.plausibility.motion import (
    TIMED,
    judge_exchanged,
    judge_inverted,
    judge_swapped,
    judge_time_unit,
    judge_times,
)
from apesim.studies.measured.plausibility.rows import CHAMBERS, Case, Row, check_rows, holding, mean, named, once
from apesim.studies.measured.plausibility.signals import select_judged
from apesim.studies.measured.plausibility.valve_bench import expect_motion, judge_stated_pulse, judge_still
from apesim.studies.measured.prediction import predict, run_of
from apesim.studies.measured.runs import MeasuredRun

FAULT, WARNING, HINT = Kind
TIME_UNIT = Row(Check.TIME_UNIT, FAULT, once("time"), judge_time_unit)
NOT_SIMULATED = "the machine cannot be simulated here", "", "what needs it is not checked; look at the machine file"
PRESSURE = Row(
    Check.LEVEL,
    WARNING,
    holding("pressure"),
    judge_pressure,
    "unit, zero or span of the gauge?",
    "see what the sensor shows in open air and at the supply",
)
SWAPPED = Row(
    Check.SWAPPED,
    FAULT,
    once(" and ".join(CHAMBERS)),
    judge_swapped,
    "a and b swapped?",
    "exchange pressure_a and pressure_b in the header, or in columns of [read]",
)
SUPPLY_TEMPERATURE = Row(
    Check.TEMPERATURE,
    WARNING,
    once("temperature"),
    judge_supply_temperature,
    right="look whether the air was so warm or cold",
)
LIFT = Row(
    Check.LIFT,
    FAULT,
    named("lift"),
    judge_lift,
    "is valve.stroke of the machine the rig's, or the gain of the sensor?",
    "write the rig's stroke, or calibrate the sensor: lift is 0 closed and the stroke open",
)
TEMPERATURE = Row(
    Check.TEMPERATURE, WARNING, holding("temperature"), judge_temperature, right="look at its unit and at the sensor"
)
VELOCITY = Row(Check.LEVEL, WARNING, named("velocity"), judge_velocity, right="look at its unit and at the calibration")

VALVE_LEVELS = (
    # Columns that stand for each other would make all checks of their levels wrong: they are judged no further.
    Row(
        Check.EXCHANGED,
        FAULT,
        once("lift and pressure_a", "lift", "pressure_a"),
        judge_exchanged,
        "lift and pressure_a swapped?",
        "exchange lift and pressure_a in the header, or in columns of [read]",
    ),
    # The chambers, and the supply behind them: it is judged by what chamber A shows at rest.
    PRESSURE._replace(where=named(*CHAMBERS)),
    SWAPPED,
    Row(
        Check.SUPPLY,
        WARNING,
        once("supply", "pressure_a"),
        judge_supply,
        "is it another run's, or has the regulator moved?",
        "write the supply that it was, or look at the sensor",
    ),
    SUPPLY_TEMPERATURE,
    # The lift, first its levels: from which stop it is measured is seen only of one within the stroke.
    LIFT,
    Row(
        Check.INVERTED,
        FAULT,
        named("lift"),
        judge_inverted,
        "inverted, measured from the open stop?",
        "give the stroke less these values: lift is 0 closed and positive towards open",
    ),
)
"""Checks of levels of a run of the valve's bench."""
VALVE_MOTION = (
    Row(
        Check.STILL,
        WARNING,
        named(*TIMED),
        judge_still,
        "did the piston stick, was the pulse given, is the sensor connected?",
        "leave the run out, if it did not move",
    ),
    Row(Check.PULSE, WARNING, once("pulse"), judge_stated_pulse),
    Row(Check.TIME_ZERO, WARNING, once("time"), judge_times),
    # Temperatures and velocity, on which no other check depends.
    TEMPERATURE,
    VELOCITY,
)
"""Checks of motion of a run of the valve's bench, and of what no other check depends on."""
ENGINE_ROWS = (
    # Every trace stands over the crank angle: with a wrong one, the checks behind it would blame the channels.
    Row(Check.CRANK_ANGLE, WARNING, once("crank_angle"), judge_crank_angle),
    PRESSURE,
    Row(
        Check.TURN,
        WARNING,
        holding("pressure"),
        judge_turn,
        "does the sensor drift, or was the engine not yet steady?",
        "record at a steady state with a warm sensor: a turn has to close",
    ),
    TEMPERATURE,
    LIFT,
    VELOCITY,
    # What no single channel shows: chambers that are swapped, what the run states, and means over the cycle.
    SWAPPED._replace(where=once(" and ".join(CHAMBERS), *CHAMBERS)),
    SUPPLY_TEMPERATURE,
    Row(
        Check.TORQUE,
        WARNING,
        mean("torque"),
        judge_torque,
        right="look at its unit, its zero and what the brake itself takes",
    ),
    Row(
        Check.AIR_FLOW,
        WARNING,
        mean("air_flow"),
        judge_air_flow,
        right="look at its unit and at leaks: it is all air, the control air too",
    ),
)
"""Checks of a run of the engine's bench."""
CYLINDER_ROWS = (
    Row(
        Check.SUPPLY, WARNING, once("pressure"), judge_given_pressure, "another run's?", "write the supply that it was"
    ),
    Row(
        Check.LEVEL,
        WARNING,
        named("force"),
        judge_force,
        "bore, unit or zero of the load cell?",
        "write the bore as rig.bore",
    ),
)
"""Checks of a way to and fro of a cylinder."""


def check_valve_run(machine: Machine, run: MeasuredRun, number: int) -> tuple[list[Finding], Expected | None]:
    """Check a run of the valve's bench, by its number from 0; None: it could not be simulated, or has other times."""
    run, findings = run._replace(channels=select_judged(run)), list[Finding]()
    case = Case(machine, run, number, run.channels, NOTHING_SHOWN)
    check_rows([TIME_UNIT], case, findings)
    if findings:
        return findings, None
    stated = expect_motion(machine, run)
    if stated is None:
        return [_not_simulated(run, number)], None
    case = check_rows(VALVE_LEVELS, case._replace(expected=stated), findings)

    # Motion depends on the supply: with a wrong one, times and pulse would be blamed for it.
    if case.run.supply != run.supply:
        case = case._replace(expected=expect_motion(machine, case.run) or stated)
    check_rows(VALVE_MOTION, case, findings)
    return findings, stated


def check_engine_run(machine: Machine, run: MeasuredRun, number: int) -> tuple[list[Finding], Expected | None]:
    """Check a run of the engine's bench, by its number from 0; None: it could not be simulated."""
    run, findings = run._replace(channels=select_judged(run)), list[Finding]()
    expected = expect(machine, run)
    if expected is None:
        return [_not_simulated(run, number)], None
    check_rows(ENGINE_ROWS, Case(machine, run, number, run.channels, expected), findings)
    return findings, expected


def check_cylinder_run(machine: Machine, run: MeasuredRun, number: int) -> tuple[list[Finding], Expected]:
    """Check a way to and fro of a cylinder, by its number from 0; the machine is shown what is given of it."""
    channels, findings = predict(run_of(machine, run), run).channels, list[Finding]()
    expected = Expected(run.times, channels, {}, False)
    check_rows(CYLINDER_ROWS, Case(machine, run, number, run.channels, expected), findings)
    return findings, expected


def _not_simulated(run: MeasuredRun, number: int) -> Finding:
    """The hint that a run could not be simulated, so that most checks were left out."""
    return Finding(HINT, Check.NOT_SIMULATED, run.data, run.name, *NOT_SIMULATED, number)
