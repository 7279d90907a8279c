"""Constants of the laws and of the march, and defaults of the machine file, as the code has them."""

from math import degrees
from operator import attrgetter

from apesim.air import ANR_DENSITY, COLDEST, HOTTEST, LEMMON_GAS_CONSTANT
from apesim.engine.cycle.operating_point import MAX_TURN
from apesim.engine.cycle.rates import MAX_PATH
from apesim.engine.machine import Machine
from apesim.engine.receiver import MAX_VOLUME
from apesim.flow_function import NEARLY_EQUAL
from apesim.march import adaptive, hybrid_system, periodic
from apesim.restriction import AREA_OF_CONDUCTANCE
from apesim.studies.estimation import calibration, levenberg_marquardt, priors
from apesim.studies.estimation.noise import process
from apesim.studies.gap.search import gap_test
from apesim.studies.limit.design_rule import MAX_WINDOW, WITHIN
from apesim.valve.actuator import MAX_STEP
from apesim.valve.motion import CREEP, DETECTED
from apesim.valve.piston import REST_SPEED
from docs.results import Number

LIVE = True

DEFAULTS = {
    "air.gas_constant": (1.0, "J/(kg·K)"),
    "air.heat_capacity_ratio": (1.0, ""),
    "valve.stroke": (1e3, "mm"),
    "valve.moving_mass": (1.0, "kg"),
    "valve.piston_area": (1e6, "mm²"),
    "valve.spring_rate": (1.0, "N/m"),
    "valve.viscous_friction": (1.0, "N·s/m"),
    "valve.solenoid.effective_area": (1e6, "mm²"),
    "valve.solenoid.dead_time": (1e3, "ms"),
    "valve.solenoid.ramp_time": (1e3, "ms"),
    "groove.effective_area": (1e6, "mm²"),
    "groove.lap": (1e3, "mm"),
    "groove.ports.diameter": (1e3, "mm"),
    "groove.ports.groove_width": (1e3, "mm"),
    "groove.ports.number": (1.0, ""),
    "groove.ports.passage_area": (1e6, "mm²"),
    "groove.ports.discharge_coefficient": (1.0, ""),
    "engine.bore": (1e3, "mm"),
    "engine.stroke": (1e3, "mm"),
    "engine.rod_length": (1e3, "mm"),
    "engine.compression_ratio": (1.0, ""),
    "engine.receiver.volume": (1e3, "L"),
    "engine.receiver.feed_area": (1e6, "mm²"),
    "engine.exhaust.effective_area": (1e6, "mm²"),
    "engine.friction.constant": (1e-5, "bar"),
    "engine.friction.peak_pressure": (1.0, ""),
    "engine.friction.piston_speed": (1e-5, "bar·s/m"),
    "engine.friction.piston_speed_squared": (1e-5, "bar·s²/m²"),
}
"""Keys of the machine file, with factor and unit of the page."""
WITH_A_TENTH = "valve.piston_area", "valve.solenoid.effective_area", "groove.lap"
"""Those of them that are printed with one decimal."""


def compute():
    """Defaults by their key in the machine file, constants by what they belong to and their name in lower case."""
    machine = Machine()
    values = {
        key: _as_written(factor * attrgetter(key)(machine), unit, 0.05 if key in WITH_A_TENTH else 0.0)
        for key, (factor, unit) in DEFAULTS.items()
    }
    others = {
        "air.lemmon_gas_constant": (round(LEMMON_GAS_CONSTANT, 3), "J/(kg·K)"),
        "air.anr_density": (ANR_DENSITY, "kg/m³"),
        "air.coldest": (COLDEST, "K"),
        "air.hottest": (HOTTEST, "K"),
        "flow.nearly_equal": (NEARLY_EQUAL, ""),
        "flow.nearly_equal_difference": (100.0 * (1.0 - NEARLY_EQUAL), "%"),
        "flow.area_of_conductance": (1e-2 * AREA_OF_CONDUCTANCE, "mm²"),  # of 1 dm³/(s·bar)
        "motion.rest_speed": (1e3 * REST_SPEED, "mm/s"),
        "motion.creep": (1e6 * CREEP, "µm/s"),
        "motion.detected": (100.0 * DETECTED, "%"),
        "motion.detected_far": (100.0 * (1.0 - DETECTED), "%"),
        "engine.largest_receiver": (1e3 * MAX_VOLUME, "L"),
        "steps.max_step": (1e3 * MAX_STEP, "ms"),
        "steps.max_turn": (degrees(MAX_TURN), "°"),
        "steps.max_path": (100.0 * MAX_PATH, "%"),
        "adaptive.max_evaluations": (1e-6 * adaptive.MAX_EVALUATIONS, "million"),
        "adaptive.max_evaluations_to_periodic": (1e-6 * adaptive.MAX_EVALUATIONS_TO_PERIODIC, "million"),
        "adaptive.max_events": (adaptive.MAX_EVENTS, ""),
        "adaptive.stiff": (adaptive.STIFF, ""),
        "adaptive.max_short_steps": (hybrid_system.MAX_SHORT_STEPS, ""),
        "periodic.max_cycles": (periodic.MAX_CYCLES, ""),
        "periodic.noise": (periodic.NOISE, ""),
        "periodic.same": (periodic.SAME, ""),
        "periodic.patience": (periodic.PATIENCE, ""),
        "periodic.burst": (periodic.BURST, ""),
        "periodic.nearer": (periodic.NEARER, ""),
        "periodic.enough": (periodic.ENOUGH, ""),
        "periodic.max_corrections": (periodic.MAX_CORRECTIONS, ""),
        "periodic.clip": (100.0 * periodic.CLIP, "%"),
        "periodic.far": (periodic.MAX_NEAR_CYCLES, ""),
        "periodic.far_step": (100.0 * periodic.LONG_STEP, "%"),
        "periodic.longest_period": (periodic.MAX_PERIOD, ""),
        "periodic.two_periods": (2 * periodic.MAX_PERIOD, ""),
        "periodic.most_periods": (periodic.MAX_PERIODS * periodic.MAX_PERIOD, ""),
        "periodic.foretold": (100.0 * periodic.FORETOLD, "%"),
        "periodic.rough_leap": (periodic.ROUGH_LEAP, ""),
        "periodic.nudge": (100.0 * periodic.NUDGE, "%"),
        "periodic.fine_nudge": (100.0 * periodic.FINE_NUDGE, "%"),
        "limit.within": (degrees(WITHIN), "°"),
        "limit.max_window": (degrees(MAX_WINDOW), "°"),
        "priors.farthest": (priors.MAX_SIGMAS, ""),
        "noise.max_order": (process.MAX_ORDER, ""),
        "noise.enough": (process.ENOUGH, ""),
        "descent.converged": (levenberg_marquardt.CONVERGED, ""),
        "descent.max_steps": (levenberg_marquardt.MAX_STEPS, ""),
        "descent.fresh": (levenberg_marquardt.FRESH, ""),
        "descent.same": (levenberg_marquardt.SAME, ""),
        "descent.foretold": (100.0 * levenberg_marquardt.FORETOLD, "%"),
        "calibration.starts": (calibration.STARTS, ""),
        "calibration.followed": (calibration.MAX_FOLLOWED, ""),
        "calibration.deeper": (calibration.DEEPER, ""),
        "gap_test.noise_draws": (gap_test.NOISE_DRAWS, ""),
        "gap_test.score_draws": (gap_test.SCORE_DRAWS, ""),
    }
    return values | {key: _as_written(value, unit) for key, (value, unit) in others.items()}


def _as_written(value, unit, error=0.0):
    """A constant in the unit of the page, without what the change of units adds in rounding."""
    return Number(float(f"{value:.10g}"), unit, error)
