"""What the paper says of the stroke: its speed and time (Figs. 9 to 11), and that opening is like closing."""

from typing import Any

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.limit.valve_map import PULSE
from apesim.studies.paper.claims.claim import Claim, Grid, verdict_of
from apesim.studies.paper.claims.delay import KNEE
from apesim.studies.run.operating_conditions import with_control_air
from apesim.valve.bench import BenchRun, run_bench

HIGH = 1.9e6
"""The paper's highest pressure [Pa gauge]."""
RATE = 10.0
"""Frequency at which opening and closing are compared in periodic operation [Hz]."""


def _rises_from_minimum(values: np.ndarray) -> bool:
    """Find whether a measure rises at every step of pressure from its least on."""
    return bool(np.all(np.diff(values[int(np.argmin(values)) :]) > 0.0))


def fluctuates_more(fluctuation: np.ndarray) -> bool:
    """Find whether the fluctuation (n,) [-] rises with pressure, to more than twice that at the lowest."""
    return _rises_from_minimum(fluctuation) and bool(fluctuation[-1] > 2.0 * fluctuation[0])


def turns_back(values: np.ndarray) -> np.ndarray:
    """Find whether a measure (n, m) neither only rises nor only falls with pressure (n), at each temperature (m).

    >>> turns_back(np.array([[1.0, 1.0], [2.0, 3.0], [3.0, 2.0]])).tolist()
    [False, True]
    """
    steps = np.diff(values, axis=0)
    return ~(np.all(steps > 0.0, axis=0) | np.all(steps < 0.0, axis=0))


def gets_slower(response: np.ndarray) -> np.ndarray:
    """Find whether the time from command to contact [s] does not fall at some step of pressure.

    The time is (n, m), over pressure and temperature; the answer (m,), for each temperature.
    """
    return np.any(np.diff(response, axis=0) >= 0.0, axis=0)


def min_difference(run: BenchRun) -> float:
    """Least pressure behind the opening piston less that ahead of it, while it moves [Pa]; NaN where it does not.

    >>> f"{min_difference(run_bench(Machine(), PULSE)) / 1e6:.2f} MPa"
    '0.13 MPa'
    """
    opening: Any = run.opening
    moving = (run.times > opening.delay) & (run.times < opening.contact)
    return float((run.trace[moving, 3] - run.trace[moving, 2]).min()) if np.any(moving) else np.nan


def fluctuation_rises(grid: Grid) -> Claim:
    """Judge the claim that the velocity fluctuates as pressure rises [EPV, discussion of Fig. 9]."""
    mean, pressure = grid.opening["fluctuation"].mean(axis=1), grid.pressure / 1e6
    least, rises = int(np.argmin(mean)), _rises_from_minimum(mean)
    return Claim(
        "fluctuation_over_pressure",
        "Fig. 9",
        "The velocity fluctuates more as the pressure rises.",
        "rises",
        f"{mean[0]:.2f} of the peak speed at {pressure[0]:.1f} MPa, {mean[least]:.2f} at {pressure[least]:.1f} MPa, "
        f"{'rising from there at every step' if rises else 'not rising from there at every step'}: {mean[-1]:.2f} at "
        f"{pressure[-1]:.1f} MPa",
        {"at_lowest_pressure": mean[0], "least": mean[least], "at_highest_pressure": mean[-1]},
        verdict_of(fluctuates_more(mean)),
        "Fluctuation: (peak speed - lowest later speed before contact)/peak. Judged by a rise at every step from its "
        "least on, to more than twice that at the lowest pressure, where only the springs brake.",
    )


def piston_rebounds(grid: Grid) -> Claim:
    """Judge the claim that the piston may even rebound [EPV, discussion of Fig. 9]."""
    count = int(grid.opening["reverses"].sum() + grid.closing["reverses"].sum())
    return Claim(
        "rebound",
        "discussion of Fig. 9",
        "At high pressure the piston even rebounds before it arrives.",
        "rebounds",
        f"turns back in {count} of {2 * grid.opening['reverses'].size} strokes",
        {"strokes_that_turn": count},
        verdict_of(count > 0),
        "Judged by a single stroke of the paper's grid, opening or closing, that turns back before contact.",
    )


def not_monotonic(grid: Grid, where: str, key: str, measure: str, name: str, unit: str, factor: float) -> Claim:
    """Judge the claim that a measure does not only rise or only fall with pressure [EPV, Figs. 9 to 11].

    `where` tells where the paper says it; `measure` is its name in the grid, `name` that in words; `factor` turns SI
    into `unit`, that it is shown in.
    """
    values = grid.opening[measure] * factor
    steps, ends = np.diff(values, axis=0), values[[0, -1]].mean(axis=1)
    mixed = int(np.sum(turns_back(values)))
    # The way back, against the direction from the lowest to the highest pressure.
    back = np.maximum(0.0, -np.sign(ends[1] - ends[0]) * steps).sum(axis=0).max()
    way_back = f", by {back:.4f} {unit} at most" if mixed else ""
    return Claim(
        key,
        where,
        f"The {name} does not change in one direction only as the pressure rises.",
        "not monotonic",
        f"{'rises' if ends[1] > ends[0] else 'falls'} from {ends[0]:.2f} {unit} at 0.1 MPa to {ends[1]:.2f} {unit} at "
        f"1.9 MPa; turns back at {mixed} of {steps.shape[1]} temperatures" + way_back,
        {
            "temperatures_not_monotonic": mixed,
            "largest_way_back": back,
            "at_lowest_pressure": ends[0],
            "at_highest_pressure": ends[1],
        },
        verdict_of(mixed == steps.shape[1]),
        "Of the opening stroke; judged, like the other trends, by all temperatures. Of t_f and v_e the paper says that "
        "they do not increase with pressure but have the maps of its figures.",
    )


def stroke_time_falls_with_temperature(grid: Grid) -> Claim:
    """Judge the claim that t_f falls with T_0 [EPV, discussion of Fig. 10]."""
    steps = np.diff(grid.opening["stroke_time_s"], axis=1) * 1e3
    return Claim(
        "stroke_time_over_temperature",
        "Fig. 10",
        "At constant pressure the full stroke time falls as the temperature rises.",
        "falls",
        f"changes by {steps.min():+.3f} to {steps.max():+.3f} ms a step of 8 K, over all pressures",
        {"lowest_step_ms": steps.min(), "highest_step_ms": steps.max()},
        verdict_of(np.all(steps < 0.0)),
        "The same square root that the paper's delay time contradicts.",
    )


def strokes_alike(machine: Machine, grid: Grid) -> Claim:
    """Judge the claim that opening and closing are almost the same [EPV, text on Fig. 7]."""
    shares = {m: grid.closing[m] / grid.opening[m] - 1.0 for m in ("delay_s", "stroke_time_s", "seating_speed_m_s")}
    ends = {m: (float(100.0 * s.min()), float(100.0 * s.max())) for m, s in shares.items()}
    by = ", ".join(
        f"{name} by {ends[m][0]:+.1f} to {ends[m][1]:+.1f} %"
        for m, name in zip(shares, ("delay time", "stroke time", "seating speed"), strict=True)
    )
    supplied = with_control_air(machine, machine.ambient.pressure + 1.0e6, 287.0)
    run = run_bench(supplied, 0.5 / RATE, period=1.0 / RATE)
    pairs = ((getattr(run.closing, f), getattr(run.opening, f)) for f in ("delay", "stroke_time", "seating_speed"))
    repeated = max(abs(closing / opening - 1.0) for closing, opening in pairs)
    largest = max(float(np.abs(s).max()) for s in shares.values())
    return Claim(
        "opening_and_closing_alike",
        "simulation analysis",
        "Opening and closing are almost the same, as the valve is symmetric.",
        "almost the same",
        f"after a rest closing differs from opening: {by}; repeated at {RATE:g} Hz (1 MPa, 287 K), by {repeated:.0e}",
        {"largest_difference": largest, "largest_difference_repeated": repeated},
        verdict_of(largest < 0.05),
        "Judged by 5 % after a rest, as the paper measures. The chambers then start from unlike states; in periodic "
        "full-stroke operation they do not, and the strokes coincide.",
    )


def response_over_pressure(grid: Grid) -> Claim:
    """Judge the claim that more pressure alone does not make the valve respond faster [EPV, conclusion]."""
    response = (grid.opening["delay_s"] + grid.opening["stroke_time_s"]) * 1e3
    mean, steps, pressure = response.mean(axis=1), np.diff(response, axis=0), grid.pressure / 1e6
    knee = int(np.argmin(np.abs(grid.pressure - KNEE)))
    return Claim(
        "response_over_pressure",
        "conclusion",
        "Increasing the pressure alone would not make the valve respond faster.",
        "not faster",
        f"command to contact changes by {steps.min():+.2f} to {steps.max():+.2f} ms a step of 0.2 MPa, over all "
        f"temperatures; on average {mean[0]:.1f} ms at {pressure[0]:.1f} MPa, {mean[knee]:.1f} ms at "
        f"{pressure[knee]:.1f} MPa, {mean[-1]:.1f} ms at {pressure[-1]:.1f} MPa",
        {"lowest_step_ms": steps.min(), "highest_step_ms": steps.max(), "mean_at_highest_pressure_ms": mean[-1]},
        verdict_of(np.all(gets_slower(response))),
        "Delay time and full stroke time of the opening stroke together; judged by a step of pressure that does not "
        "make it faster, at all temperatures. Above 0.7 MPa there is little left to win.",
    )


def pressure_to_be_optimised(grid: Grid) -> Claim:
    """Judge the claim that some pressure gives a fast response and a low seating speed [EPV, discussion of Fig. 11].

    Both are judged at one temperature.
    """
    response = (grid.opening["delay_s"] + grid.opening["stroke_time_s"]) * 1e3
    speed, pressure = grid.opening["seating_speed_m_s"], grid.pressure / 1e6
    fastest, softest = np.argmin(response, axis=0), np.argmin(speed, axis=0)
    last = len(pressure) - 1
    inside = (fastest > 0) & (fastest < last) | (softest > 0) & (softest < last)
    texts = [", ".join(f"{p:.1f}" for p in np.unique(pressure[at])) for at in (fastest, softest)]
    return Claim(
        "pressure_to_be_optimised",
        "discussion of Fig. 11",
        "At one temperature the control pressure should be optimised for a fast response and a low seating speed.",
        "an optimum",
        f"of {pressure[0]:.1f} to {pressure[-1]:.1f} MPa the fastest is {texts[0]}, the softest {texts[1]} MPa, over "
        f"all temperatures; an optimum lies inside the range at {np.sum(inside)} of {len(inside)} temperatures",
        {
            "temperatures_with_an_optimum_inside": int(np.sum(inside)),
            "lowest_response_ms": response.min(),
            "highest_response_ms": response.max(),
            "lowest_seating_speed_m_s": speed.min(),
            "highest_seating_speed_m_s": speed.max(),
        },
        verdict_of(np.all(inside)),
        "Judged by a least time from command to contact, or a least seating speed, that lies inside the range of "
        "pressures, at all temperatures. Without one the choice is a compromise between the two.",
    )


def fluctuation_from_limited_area(machine: Machine) -> Claim:
    """Judge the claim that the fluctuation comes from the solenoids' limited area, and only at high pressure.

    The claim is in [EPV, discussion of Fig. 9].
    """
    values, valve = {}, machine.valve
    for factor in (1.0, 4.0):
        area = factor * valve.solenoid.effective_area
        wide = machine._replace(valve=valve._replace(solenoid=valve.solenoid._replace(effective_area=area)))
        run = run_bench(with_control_air(wide, machine.ambient.pressure + HIGH, 287.0), PULSE)
        opening: Any = run.opening
        values[f"fluctuation_at_{factor:g}_times_the_area"] = opening.fluctuation
    narrow, wide = values.values()
    return Claim(
        "fluctuation_from_limited_area",
        "discussion of Fig. 9",
        "The fluctuation is related to the limited effective area of the solenoid valves.",
        "limited area",
        f"{narrow:.2f} of the peak speed at 1.9 MPa, {wide:.2f} with four times the area",
        values,
        verdict_of(narrow > 0.01 and wide < 0.1 * narrow),
        "Judged by a tenth of it being left, where it is more than 0.01.",
    )


def pressures_cross(machine: Machine) -> Claim:
    """Judge the claim that the piston brakes until the pressure behind exceeds that before it again [EPV, Fig. 9]."""
    run = run_bench(with_control_air(machine, machine.ambient.pressure + HIGH, 287.0), PULSE, sample=2e-5)
    opening: Any = run.opening
    least, opened = min_difference(run), run.times < opening.contact
    peak = float(np.abs(run.trace[opened, 1]).max()) if np.any(opened) else np.nan
    drag = machine.valve.viscous_friction * peak / machine.valve.piston_area
    return Claim(
        "pressure_behind_falls_below",
        "discussion of Fig. 9",
        "The piston compresses the air ahead and brakes until the pressure behind it exceeds that before it again.",
        "falls below",
        f"at 1.9 MPa the pressure behind stays at least {least / 1e6:.2f} MPa above that ahead; the viscous force at "
        f"peak speed is that of {drag / 1e6:.2f} MPa",
        {"least_difference_Pa": least, "viscous_force_over_area_Pa": drag},
        verdict_of(least < 0.0),
        "It is viscous friction that brakes: the falling difference of pressure no longer keeps up with it.",
    )
