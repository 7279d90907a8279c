"""What the paper says of the valve in the engine: that 30 Hz are enough, that temperature is easy to correct."""

from collections.abc import Callable
from functools import cache

import numpy as np

from apesim.engine.angles import DEGREE, RPM
from apesim.engine.cylinder import EPV
from apesim.engine.machine import Machine
from apesim.studies.limit.engine_limit import WITHIN, Failure, engine_limit, judged, lasting
from apesim.studies.paper.claims.area import AREAS, with_area
from apesim.studies.paper.claims.claim import Claim, range_of, verdict_of, with_range
from apesim.studies.paper.claims.design import RATE
from apesim.studies.run.operating_conditions import with_control_air, with_supply
from apesim.studies.timing.solve import corrected

GAUGE = 1.0e6
"""Pressure of the supply in the engine: the paper names none [Pa gauge]."""
SPEED = RATE * 60.0
"""Engine speed at the valve's working frequency, one event a revolution [r/min]."""
WINDOWS = (60.0, 75.0, 90.0, 105.0, 120.0, 150.0, 180.0, 240.0, 300.0)
"""Windows tried, from opening to closing [deg]."""
WINDOW_RESOLUTION = 0.5
"""How closely the least window is found [deg]."""
TEMPERATURES = np.linspace(250.0, 322.0, 5)
"""The paper's range [K]."""
CORRECTED_AT = (600.0, 1000.0)
"""Speeds at which commands are corrected [r/min]."""


def supplied(machine: Machine, temperature: float = 287.0) -> Machine:
    """The engine with its electro-pneumatic intake, at the pressure of these claims.

    `temperature` of the supply in K.
    """
    engine, pressure = machine.engine._replace(intake=EPV), machine.ambient.pressure + GAUGE
    return with_control_air(with_supply(machine._replace(engine=engine), pressure, temperature), pressure)


def _works(machine: Machine, window: float) -> bool:
    """Find whether an intake that is open for a window meets the criterion of `engine limit` at 30 Hz."""
    return judged(lasting(machine, window * DEGREE), SPEED * RPM)[0] == Failure.NONE


def min_window(meets: Callable[[float], bool]) -> float:
    """Find the shortest window [deg] that meets the criterion; NaN where none of those tried does."""
    first = next((number for number, window in enumerate(WINDOWS) if meets(window)), None)
    if first is None:
        return np.nan
    good, bad = WINDOWS[first], WINDOWS[max(first - 1, 0)]
    while good - bad > WINDOW_RESOLUTION:
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if meets(middle) else (good, middle)
    return good


def speed_demand(machine: Machine) -> Claim:
    """Judge the claim that 30 Hz satisfy the engine's speed demand [EPV, discussion of Fig. 10]; this takes seconds."""
    engine = supplied(machine)
    own_window = (engine.command.close_target - engine.command.open_target) / DEGREE

    # Answers are kept: the search for the least window and the verdicts below ask for many of the same windows.
    meets, wide = cache(lambda window: _works(engine, window)), with_area(engine, AREAS[-1])
    limit, least = engine_limit(engine).limit / RPM, min_window(meets)
    widest = min_window(lambda window: _works(wide, window))

    # A claim for the machine's own window, which is the answer, and one for each window tried, as the paper names none.
    # Rounded, an own window that is one of these is tried once.
    tried = sorted({*WINDOWS, round(own_window, 6)})
    claims = [
        Claim(
            "speed_demand",
            "discussion of Fig. 10",
            "Its frequency of 30 Hz can satisfy the speed demand of the engine.",
            f"{RATE:g} Hz, {SPEED:g} r/min",
            f"with the intake open for {own_window:g}° the targets are met by complete strokes up to {limit:.0f} r/min "
            f"({limit / 60.0:.1f} Hz); {SPEED:g} r/min needs {least:.1f}° or more, and {widest:.1f}° even if the "
            "solenoids' effective area were their whole 4 mm bore",
            {
                "own_window_deg": own_window,
                "limit_rpm_at_own_window": limit,
                "least_window_deg": least,
                "least_window_deg_at_12.5_mm2": widest,
            },
            verdict_of(meets(window)),
            f"Judged by the criterion of apesim engine limit ({WITHIN / DEGREE:g}°, full lift, full closure), at "
            f"{GAUGE / 1e6:g} MPa and 287 K, in the default window. The paper names no window.",
        )
        for window in (own_window, *tried)
    ]
    return with_range(claims[0], range_of("window", "deg", tried, claims[1:]))


def correction(machine: Machine) -> Claim:
    """Judge the claim that it is easy to correct the engine's advance and delay angles for temperature.

    The claim is in [EPV, discussion of Fig. 8]. The engine is run at two speeds and five temperatures, which takes
    seconds.
    """
    values, deviations = {}, []
    for speed in CORRECTED_AT:
        timings = [corrected(supplied(machine, temperature), speed * RPM) for temperature in TEMPERATURES]

        # A straight line through the ends of the range: the correction is easy where the angles stay near it.
        for name in ("advance", "release_advance"):
            angles = np.array([getattr(timing, name) for timing in timings]) / DEGREE
            line = np.interp(TEMPERATURES, TEMPERATURES[[0, -1]], angles[[0, -1]])
            deviations.append(np.abs(angles - line).max())
            values[f"{name}_change_deg_at_{speed:g}_rpm"] = angles[-1] - angles[0]

    # Two changes for each speed, that of the opening and that of the closing, in the order of the loop above.
    changes = list(values.values())
    advances = "; ".join(
        f"{changes[2 * i]:+.2f}° and {changes[2 * i + 1]:+.2f}° at {speed:g} r/min"
        for i, speed in enumerate(CORRECTED_AT)
    )

    # Near is within the angle by which the valve may miss its targets.
    worst = max(deviations)
    return Claim(
        "correction_for_temperature",
        "discussion of Fig. 8",
        "A large difference of temperature is easy to correct in the engine's advance and delay angles.",
        "easy, as linear",
        f"from 250 to 322 K the advances of opening and closing change by {advances}, and differ from a straight line "
        f"by up to {worst:.2f}°",
        values | {"largest_deviation_deg": worst},
        verdict_of(worst < WITHIN / DEGREE),
        f"Commands by which the valve opens and closes at the machine's targets, at {GAUGE / 1e6:g} MPa; judged by "
        f"{WITHIN / DEGREE:g}°. The line's slope depends on the speed, for the closing much, and is a fall: warmer air "
        "needs less advance.",
    )
