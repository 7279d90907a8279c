"""What the paper says of the delay time over pressure and temperature (Fig. 8)."""

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.paper.claims.claim import NOT_COMPUTABLE, Claim, Grid, verdict_of
from apesim.studies.run.operating_conditions import with_control_air
from apesim.valve.bench import run_bench

SIZE = 0.41
"""Largest change of the delay time with temperature, by the paper [ms]."""
KNEE = 0.7e6
"""Gauge pressure at which the delay time levels off, by the paper [Pa]."""


def delay_rises_with_pressure(grid: Grid) -> Claim:
    """Judge the claim that t_d increases with p_in [EPV, discussion of Fig. 8]."""
    steps = np.diff(grid.opening["delay_s"], axis=0) * 1e3
    return Claim(
        "delay_over_pressure",
        "Fig. 8",
        "The delay time rises with the control pressure.",
        "rises",
        f"changes by {steps.min():+.3f} to {steps.max():+.3f} ms a step of 0.2 MPa, over all temperatures",
        {"least_step_ms": steps.min(), "largest_step_ms": steps.max()},
        verdict_of(np.all(steps > 0.0)),
        "More air has to leave chamber A before the piston starts.",
    )


def delay_levels_off(grid: Grid) -> Claim:
    """Judge the claim that t_d rises steeply below 0.7 MPa and little above [EPV, discussion of Fig. 8]."""
    delay = grid.opening["delay_s"].mean(axis=1) * 1e3
    pressure = grid.pressure / 1e6
    knee = int(np.argmin(np.abs(grid.pressure - KNEE)))
    below = (delay[knee] - delay[0]) / (pressure[knee] - pressure[0])
    above = (delay[-1] - delay[knee]) / (pressure[-1] - pressure[knee])
    return Claim(
        "delay_levels_off",
        "Fig. 8",
        "Below 0.7 MPa the delay time rises rapidly with pressure, above it little.",
        "rapid, then little",
        f"{below:.2f} ms/MPa below, {above:.3f} ms/MPa above",
        {"below_ms_per_MPa": below, "above_ms_per_MPa": above},
        verdict_of(below > 5.0 * above > 0.0),
        "Judged by a slope at least five times as large.",
    )


def delay_and_temperature(machine: Machine, grid: Grid) -> Claim:
    """Judge the claim that t_d increases with T_0 [EPV, discussion of Fig. 8]."""
    change = (grid.opening["delay_s"][:, -1] - grid.opening["delay_s"][:, 0]) * 1e3
    times = emptying_times(machine)
    scaled = np.array([time * np.sqrt(temperature) for temperature, time in times.items()])
    spread = float(np.ptp(scaled) / scaled.mean())
    listed = ", ".join(f"{1e3 * time:.4f} ms at {temperature:g} K" for temperature, time in times.items())
    return Claim(
        "delay_over_temperature",
        "Fig. 8",
        "The delay time rises with the control air's temperature.",
        "rises",
        f"changes by {change.min():+.2f} to {change.max():+.2f} ms from 250 to 322 K, over all pressures",
        {"lowest_change_ms": change.min(), "highest_change_ms": change.max()}
        | {f"time_s_at_{temperature:g}_K": time for temperature, time in times.items()}
        | {"spread": spread},
        verdict_of(np.all(change > 0.0)),
        "Chambers would have to empty more slowly in warmer air. By Eqs. 3-8 they empty in proportion to the time "
        "V/(S sqrt(R T_0)), which falls with T_0. "
        f"With the piston held and instant solenoids A falls to 0.8 of its pressure in {listed}: times sqrt(T_0) equal "
        f"within {spread:.0e}.",
    )


def emptying_times(machine: Machine) -> dict[float, float]:
    """Find how long chamber A takes to 0.8 of its pressure [s], by temperature of the air [K], the piston at rest.

    NaN where the piston moves before.

    >>> {temperature: f"{1e3 * time:.2f} ms" for temperature, time in emptying_times(Machine()).items()}
    {250.0: '2.12 ms', 287.0: '1.98 ms', 322.0: '1.87 ms'}
    """
    valve = machine.valve
    instant = valve._replace(
        solenoid=valve.solenoid._replace(dead_time=0.0, ramp_time=1e-6, opening_curve=np.empty((0, 2)))
    )
    volume = valve.clearance_volume + valve.piston_area * valve.stroke
    until = volume / (valve.solenoid.effective_area * np.sqrt(machine.air.gas_constant * 287.0)) / 2.5
    times = {}
    for temperature in (250.0, 287.0, 322.0):
        run = run_bench(
            with_control_air(machine, machine.ambient.pressure + 1.0e6, temperature)._replace(valve=instant),
            2.0 * until,
            until=until,
            sample=until / 1500.0,
        )
        pressure = run.trace[:, 2]
        at = float(np.interp(-0.8 * pressure[0], -pressure, run.times, right=np.nan))
        times[temperature] = at if np.interp(at, run.times, run.trace[:, 0]) == 0.0 else np.nan  # the piston held
    return times


def size_of_temperature(grid: Grid, chosen: bool) -> Claim:
    """Judge the claim that t_d changes by 0.41 ms at most over 250 to 322 K [EPV, discussion of Fig. 8].

    `chosen` tells that the valve's area was chosen by this number, which then proves nothing.
    """
    changes = (grid.opening["delay_s"][:, -1] - grid.opening["delay_s"][:, 0]) * 1e3
    change = changes[np.argmax(np.abs(changes))]
    sign = "a rise, as in the paper" if change > 0.0 else "a fall, where the paper has a rise"
    return Claim(
        "size_of_temperature",
        "Fig. 8",
        "Over 250 to 322 K the delay time changes by 0.41 ms at most.",
        "0.41 ms",
        f"{abs(change):.2f} ms: {sign}",
        {"change_ms": change},
        NOT_COMPUTABLE if chosen else verdict_of(abs(abs(change) - SIZE) < 0.1 * SIZE),
        "The size alone, without its sign. It depends on the solenoids' effective area, which the paper does not print "
        "and which was chosen by this number. Another valve is judged by a tenth of it.",
    )


def delay_is_linear(grid: Grid) -> Claim:
    """Judge the claim that t_d over T_0 is almost linear [EPV, discussion of Fig. 8]."""
    delay, temperature = grid.opening["delay_s"], grid.temperature
    chord = delay[:, :1] + (delay[:, -1:] - delay[:, :1]) * (temperature - temperature[0]) / np.ptp(temperature)
    share = np.abs(delay - chord).max(axis=1) / np.abs(delay[:, -1] - delay[:, 0])
    return Claim(
        "delay_linear_in_temperature",
        "Fig. 8",
        "The delay time is almost linear in temperature.",
        "almost linear",
        f"within {share.max() * 100:.1f} % of the change from a straight line",
        {"largest_deviation_share": share.max()},
        verdict_of(share.max() < 0.1),
        "Judged by a tenth of the change.",
    )
