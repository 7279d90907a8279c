"""What the paper says, and what its equations give."""

from typing import NamedTuple

import numpy as np

from studies.limit import working_limit
from studies.valve_map import with_supply
from valve.bench import run_bench
from valve.effects.coulomb_friction import CoulombFriction

REPRODUCED, CONTRADICTED, CALIBRATED, NOT_COMPUTABLE = "reproduced", "contradicted", "calibrated", "not computable"
PULSE = 50e-3
KNEE = 0.7e6
"""Gauge pressure at which the delay time levels off, by the paper [Pa]."""


class Claim(NamedTuple):
    """A claim of the paper beside the model's answer."""

    key: str
    where: str
    """In the paper."""
    claim: str
    paper: str
    """Its number or trend."""
    ours: str
    """The model's."""
    values: dict
    """The model's numbers, SI unless the name says otherwise."""
    verdict: str
    remark: str


class Grid(NamedTuple):
    """The paper's map, as arrays over gauge pressure and temperature."""

    pressure: np.ndarray
    """[Pa gauge], shape (n,)"""
    temperature: np.ndarray
    """[K], shape (m,)"""
    opening: dict
    """By measure, shape (n, m)."""
    closing: dict


def grid_of(archive, ambient_pressure):
    """The grid of a valve map.

    Parameters
    ----------
    archive : Archive
        See `studies.valve_map.map_valve`.
    ambient_pressure : float
        [Pa abs]

    Returns
    -------
    Grid
    """
    v = {name: variable.values for name, variable in archive.variables.items()}
    pressure, temperature = np.unique(v["supply_pressure"]), np.unique(v["supply_temperature"])
    shape = (len(pressure), len(temperature))
    measures = ("delay_s", "stroke_time_s", "seating_speed_m_s", "fluctuation", "reverses")
    strokes = [{name: v[f"{stroke}_{name}"].reshape(shape) for name in measures} for stroke in ("opening", "closing")]
    return Grid(pressure - ambient_pressure, temperature, *strokes)


def verdict_of(holds):
    """Reproduced or contradicted."""
    return REPRODUCED if holds else CONTRADICTED


def delay_rises_with_pressure(grid):
    """t_d increases with p_in (Fig. 8)."""
    steps = np.diff(grid.opening["delay_s"], axis=0) * 1e3
    return Claim(
        "delay_over_pressure",
        "Fig. 8",
        "The delay time rises with the control pressure.",
        "rises",
        f"rises at every temperature, by {steps.min():.3f} to {steps.max():.3f} ms a step of 0.2 MPa",
        {"least_step_ms": steps.min(), "largest_step_ms": steps.max()},
        verdict_of(np.all(steps > 0.0)),
        "More air has to leave chamber A before the piston starts.",
    )


def delay_levels_off(grid):
    """t_d rises steeply below 0.7 MPa and little above."""
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


def delay_and_temperature(grid):
    """t_d increases with T_0 (Fig. 8)."""
    change = (grid.opening["delay_s"][:, -1] - grid.opening["delay_s"][:, 0]) * 1e3
    return Claim(
        "delay_over_temperature",
        "Fig. 8",
        "The delay time rises with the control air's temperature.",
        "rises",
        f"falls at every pressure, by {-change.max():.2f} to {-change.min():.2f} ms from 250 to 322 K",
        {"least_fall_ms": -change.max(), "largest_fall_ms": -change.min()},
        verdict_of(np.all(change > 0.0)),
        "Flow speeds up as the square root of temperature, and nothing in Eqs. 1-8 slows down with it; see "
        "temperature_scaling.",
    )


def size_of_temperature(grid):
    """At most 0.41 ms over 250...322 K."""
    size = np.abs(grid.opening["delay_s"][:, -1] - grid.opening["delay_s"][:, 0]).max() * 1e3
    return Claim(
        "size_of_temperature",
        "Fig. 8",
        "Over 250 to 322 K the delay time changes by 0.41 ms at most.",
        "0.41 ms",
        f"{size:.2f} ms",
        {"change_ms": size},
        CALIBRATED,
        "The solenoids' effective area, which the paper does not print, was chosen by this number.",
    )


def delay_is_linear(grid):
    """t_d over T_0 is almost linear."""
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


def fluctuation_rises(grid):
    """The velocity fluctuates as pressure rises (Fig. 9)."""
    mean = grid.opening["fluctuation"].mean(axis=1)
    return Claim(
        "fluctuation_over_pressure",
        "Fig. 9",
        "The velocity fluctuates more as the pressure rises.",
        "rises",
        f"{mean[0]:.2f} of the peak speed at 0.1 MPa, {mean[-1]:.2f} at 1.9 MPa",
        {"at_lowest_pressure": mean[0], "at_highest_pressure": mean[-1]},
        verdict_of(mean[-1] > mean[0] and np.polyfit(grid.pressure, mean, 1)[0] > 0.0),
        "Fluctuation: (peak speed - lowest later speed before contact)/peak.",
    )


def piston_rebounds(grid):
    """The piston may even rebound."""
    count = int(grid.opening["reverses"].sum() + grid.closing["reverses"].sum())
    return Claim(
        "rebound",
        "discussion of Fig. 9",
        "At high pressure the piston slows down and even rebounds before it arrives.",
        "rebounds",
        f"turns back in {count} of {2 * grid.opening['reverses'].size} strokes",
        {"strokes_that_turn": count},
        verdict_of(count > 0),
        "It slows down, but keeps its direction at every point of the paper's grid.",
    )


def not_monotonic(grid, key, measure, name, unit, factor):
    """A measure that does not only rise or only fall with pressure (Figs. 10, 11)."""
    steps = np.diff(grid.opening[measure], axis=0) * factor
    mixed = int(np.sum(~(np.all(steps > 0.0, axis=0) | np.all(steps < 0.0, axis=0))))
    ends = grid.opening[measure][[0, -1]].mean(axis=1) * factor
    return Claim(
        key,
        "Figs. 10, 11",
        f"The {name} does not change in one direction only as the pressure rises.",
        "not monotonic",
        f"not monotonic at {mixed} of {steps.shape[1]} temperatures; {ends[0]:.2f} {unit} at 0.1 MPa, "
        f"{ends[1]:.2f} {unit} at 1.9 MPa",
        {"temperatures_not_monotonic": mixed, "at_lowest_pressure": ends[0], "at_highest_pressure": ends[1]},
        verdict_of(mixed > 0),
        "Of the opening stroke.",
    )


def stroke_time_falls_with_temperature(grid):
    """t_f falls with T_0."""
    steps = np.diff(grid.opening["stroke_time_s"], axis=1) * 1e3
    return Claim(
        "stroke_time_over_temperature",
        "Fig. 10",
        "At constant pressure the full stroke time falls as the temperature rises.",
        "falls",
        f"falls everywhere, by {-steps.max():.3f} to {-steps.min():.3f} ms a step of 8 K",
        {"least_fall_ms": -steps.max(), "largest_fall_ms": -steps.min()},
        verdict_of(np.all(steps < 0.0)),
        "The same square root that the paper's delay time contradicts.",
    )


def strokes_alike(grid):
    """Opening and closing are almost the same."""
    shares = [
        np.abs(grid.closing[m] / grid.opening[m] - 1.0) for m in ("delay_s", "stroke_time_s", "seating_speed_m_s")
    ]
    least, most = min(s.min() for s in shares), max(s.max() for s in shares)
    return Claim(
        "opening_and_closing_alike",
        "simulation analysis",
        "Opening and closing are almost the same, as the valve is symmetric.",
        "almost the same",
        f"differ by {least * 100:.1f} to {most * 100:.1f} % after a rest",
        {"least_difference": least, "largest_difference": most},
        verdict_of(most < 0.1),
        "After a rest the chambers start from unlike states; in periodic full-stroke operation the strokes coincide.",
    )


def working_frequency(machine):
    """About 30 Hz."""
    ambient = machine.ambient.pressure
    limits = {
        (pressure, duty): working_limit(with_supply(machine, ambient + pressure * 1e6, 287.0), duty, 0.1).limit
        for pressure in (0.16, 0.4, 1.0)
        for duty in (0.3, 0.5)
    }
    told = "; ".join(f"{limits[p, 0.3]:.1f} and {limits[p, 0.5]:.1f} Hz at {p:g} MPa" for p in (0.16, 0.4, 1.0))
    return Claim(
        "working_frequency",
        "abstract",
        "The valve works up to about 30 Hz.",
        "about 30 Hz",
        f"every stroke complete, energised for 0.3 and 0.5 of the period: {told}",
        {f"limit_hz_at_{p:g}_MPa_duty_{d:g}": value for (p, d), value in limits.items()},
        verdict_of(all(value >= 30.0 for (p, d), value in limits.items() if p >= 0.4 and d == 0.5)),
        "The paper names no duty. The limit depends on it more than on pressure.",
    )


def engine_speed():
    """30 Hz are 2000 r/min."""
    return Claim(
        "engine_speed",
        "abstract",
        "30 Hz correspond to an engine speed of 2000 r/min.",
        "2000 r/min",
        "1800 r/min at one event a revolution; 2000 r/min are 33.3 Hz",
        {"speed_rpm": 30.0 * 60.0, "rate_hz": 2000.0 / 60.0},
        CONTRADICTED,
        "Arithmetic.",
    )


def gauge_pressures(machine, pressure=0.4e6, k=1.4):
    """The pressures are gauge, Eqs. 7-10 need absolute ones."""
    absolute = pressure + machine.ambient.pressure
    ratio = absolute / pressure
    return Claim(
        "gauge_pressures",
        "Eqs. 7-10, Figs. 3-4",
        "Pressures are given relative to ambient, and put into Eqs. 7-10.",
        "gauge",
        f"Eq. 10 with gauge pressures gives {100 * (ratio - 1.0):.0f} % too large an area at the start of a discharge "
        "from 0.4 MPa",
        {"area_ratio": ratio, "exponent": (1.0 - 3.0 * k) / (2.0 * k) + (k - 1.0) / (2.0 * k)},
        CONTRADICTED,
        "At p = p_ini the pressures of Eq. 10 have the exponent -1 in all. apesim takes absolute pressures only.",
    )


def sign_of_outflow(machine):
    """Eq. 4 adds dm_out."""
    run = run_bench(machine, PULSE)
    return Claim(
        "sign_of_outflow",
        "Eq. 4",
        "The mass of a chamber changes by the inflow plus the outflow.",
        "dm = dm_in + dm_out",
        f"with Eq. 7's positive flows it is the difference; so counted, mass closes to {run.closure['mass']:.0e}",
        {"mass_closure": run.closure["mass"]},
        CONTRADICTED,
        "Right only where dm_out is taken to be negative, which the paper does not say.",
    )


def friction_is_small(machine):
    """Coulomb friction below 1.1 N is negligible."""
    supplied = with_supply(machine, machine.ambient.pressure + 0.4e6, 287.0)
    rubbed = supplied._replace(effects=supplied.effects._replace(coulomb_friction=CoulombFriction(1.1, 1.1)))
    base, other = run_bench(supplied, PULSE).opening, run_bench(rubbed, PULSE).opening
    changes = [getattr(other, f) / getattr(base, f) - 1.0 for f in ("delay", "stroke_time", "seating_speed")]
    return Claim(
        "friction_is_negligible",
        "experimental validation",
        "Coulomb friction is below 1.1 N and negligible.",
        "negligible",
        f"1.1 N change delay, stroke time and seating speed by {', '.join(f'{100 * c:+.2f} %' for c in changes)}",
        dict(zip(("delay_change", "stroke_time_change", "seating_speed_change"), changes, strict=True)),
        verdict_of(max(map(abs, changes)) < 0.01),
        "At 0.40 MPa; judged by 1 %.",
    )


def springs_soften(machine):
    """The springs' main function is to soften the impact."""
    supplied = with_supply(machine, machine.ambient.pressure + 0.4e6, 287.0)
    free = supplied._replace(valve=supplied.valve._replace(spring_rate=0.0))
    with_springs, without = run_bench(supplied, PULSE).opening, run_bench(free, PULSE).opening
    change = with_springs.seating_speed / without.seating_speed - 1.0
    return Claim(
        "springs_soften_the_impact",
        "system dynamics",
        "The springs' main function is to soften the piston's impact.",
        "softer",
        f"seating speed {with_springs.seating_speed:.3f} m/s with springs, {without.seating_speed:.3f} m/s without "
        f"({100 * change:+.1f} %)",
        {"with_springs_m_s": with_springs.seating_speed, "without_m_s": without.seating_speed},
        verdict_of(change < 0.0),
        "They push in the first half of the stroke as much as they brake in the second.",
    )


def temperature_scaling(machine):
    """Filling and venting at rest scale with 1/sqrt(T_0): a pressure is reached earlier in warmer air."""
    valve = machine.valve
    instant = valve._replace(
        solenoid=valve.solenoid._replace(dead_time=0.0, ramp_time=1e-6, opening_curve=np.empty((0, 2)))
    )
    times = {}
    for temperature in (250.0, 287.0, 322.0):
        run = run_bench(
            with_supply(machine, machine.ambient.pressure + 1.0e6, temperature)._replace(valve=instant),
            PULSE,
            until=3e-3,
            sample=2e-6,
        )
        pressure = run.trace[:, 2]
        times[temperature] = float(np.interp(-0.8 * pressure[0], -pressure, run.times))
    scaled = np.array([time * np.sqrt(temperature) for temperature, time in times.items()])
    spread = float(np.ptp(scaled) / scaled.mean())
    told = ", ".join(f"{1e3 * time:.4f} ms at {temperature:g} K" for temperature, time in times.items())
    return Claim(
        "temperature_scaling",
        "dimensional argument",
        "Why the delay time cannot rise with temperature: a chamber's time scale is V/(S sqrt(R T_0)).",
        "-",
        f"chamber A falls to 0.8 of its pressure in {told}; times sqrt(T_0) equal within {spread:.0e}",
        {f"time_s_at_{temperature:g}_K": time for temperature, time in times.items()} | {"spread": spread},
        verdict_of(False),
        "The piston held, the solenoids instant: nothing else in Eqs. 3-8 has a time. It carries the contradiction "
        "delay_over_temperature.",
    )


def not_computable():
    """Claims that rest on measurements which the paper does not give as numbers."""
    told = "the measured curves survive as figures only"
    return [
        Claim(
            "viscous_friction",
            "experimental validation",
            "The viscous friction coefficient is 111.08 N s/m.",
            "111.08 N s/m",
            told,
            {"paper": 111.08},
            NOT_COMPUTABLE,
            "`apesim valve fit` finds it from data of the same kind.",
        ),
        Claim(
            "time_error",
            "Fig. 6",
            "At 0.16 and 0.49 MPa simulated and measured lift differ by less than 1.2 ms.",
            "below 1.2 ms",
            told,
            {"paper_ms": 1.2},
            NOT_COMPUTABLE,
            "`apesim valve fit` measures it on a user's check runs.",
        ),
    ]


def all_claims(machine, archive):
    """Every claim, judged.

    Parameters
    ----------
    machine : engine.machine.Machine
    archive : Archive
        The map over the paper's grid, see `studies.valve_map.map_valve`.

    Returns
    -------
    list of Claim
    """
    grid = grid_of(archive, machine.ambient.pressure)
    return [
        delay_rises_with_pressure(grid),
        delay_levels_off(grid),
        delay_and_temperature(grid),
        temperature_scaling(machine),
        size_of_temperature(grid),
        delay_is_linear(grid),
        fluctuation_rises(grid),
        piston_rebounds(grid),
        not_monotonic(grid, "stroke_time_over_pressure", "stroke_time_s", "full stroke time", "ms", 1e3),
        not_monotonic(grid, "seating_speed_over_pressure", "seating_speed_m_s", "seating speed", "m/s", 1.0),
        stroke_time_falls_with_temperature(grid),
        strokes_alike(grid),
        working_frequency(machine),
        engine_speed(),
        gauge_pressures(machine),
        sign_of_outflow(machine),
        friction_is_small(machine),
        springs_soften(machine),
        *not_computable(),
    ]
