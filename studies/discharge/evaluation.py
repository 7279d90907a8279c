"""Discharge tests evaluated: each alone, compared, pooled, and turned into a curve that the valve can be run with."""

from collections.abc import Iterator, Sequence
from math import nan
from typing import Any, NamedTuple

import numpy as np

from apesim.quantities import Fault, InputError
from apesim.studies.discharge.area import AreaFit, fit_area
from apesim.studies.discharge.collapse import Collapse, collapse_of
from apesim.studies.discharge.opening import (
    MAX_HALF_BAND,
    Plateau,
    cut,
    find_cut_off,
    find_plateau,
    leaves_band,
    opening_curve,
)
from apesim.studies.discharge.records import MIN_RATIO, Record, fitted_part, noise_before
from apesim.studies.discharge.vessel import Vessel
from apesim.studies.discharge.wall import Wall, find_choked, fit_wall

CUT_OFF = (
    f"reported while p > {MIN_RATIO:g} p_ambient and half the 95 % band is below {MAX_HALF_BAND:.0%} of the full area"
)
METHOD = (
    "S(t), straight between knots, through Eq. 10 forward to all samples; a random walk of the largest marginal "
    "likelihood, undersmoothed; noise from before the switch and from what is left; 95 % point-wise with the bias of "
    "smoothing"
)
LOW_CRITICAL_RATIO = 0.3
"""Critical pressure ratio that solenoid valves seldom fall below: up to it their flow is choked."""
HEADER = ("time [ms]", "opening [-]", "effective_area [mm^2]", "low [mm^2]", "high [mm^2]")


class Discharge(NamedTuple):
    """What discharge tests say of a valve."""

    records: list[Record]
    """The tests as fitted, `Record`: down to `MIN_RATIO`, long ones averaged to at most `MAX_SAMPLES`."""
    noise: list[float]
    """Standard deviation of single samples before the valve is switched, by test [Pa]."""
    fits: list[AreaFit]
    """Fit of each test alone, `AreaFit`."""
    ends: list[float]
    """Until when each test tells [s]."""
    pooled: AreaFit
    end: float
    """Until when all tests together tell [s]."""
    full_area: float
    """Effective area of the open valve [m2]; NaN: there is none, see `refusal`."""
    full_area_half_band: float
    """[m2]"""
    curve: np.ndarray
    """Time [s], opening, effective area and ends of its band [m2], shape (m, 5); no row where there is no curve."""
    collapse: Collapse | None
    """`Collapse`; None of a single test."""
    warnings: list[str]
    wall: Wall | None = None
    """What the tests say of the heat from the wall; None: nothing, or it was stated that the vessel is isothermal."""
    refusal: str = ""
    """Why there is no curve, and what helps; "": there is one."""


def discharge(vessel: Vessel, records: Sequence[Record]) -> Discharge:
    """Find the effective area of a valve over the time after its switch, from discharge tests, see `read_test`.

    Raises InputError where the tests are too noisy to tell anything.
    """
    parts = [fitted_part(record, vessel.ambient_pressure) for record in records]
    # Without heat from the wall first: where the tests do not tell it, this is the result.
    first = fit_area(vessel, parts)
    lasts = [part.times[-1] for part in parts]
    # The open valve, by the choked part, in which neither its critical ratio nor cold gas has a say. Where the area is
    # not constant up to the ratio of a nozzle, the valve may be choked for a shorter time.
    for critical_ratio in (vessel.gas.critical_ratio, LOW_CRITICAL_RATIO):
        (pooled, opened), stated = first, vessel
        wall = None if vessel.wall else fit_wall(vessel, parts, pooled, opened, critical_ratio)
        if wall and wall.is_identified:
            stated = vessel._replace(wall=wall.conductance / wall.area)
            pooled, opened = fit_area(stated, parts)
        pairs = zip(parts, pooled.pressures, strict=True)
        choked, end = max(find_choked(vessel, *pair, critical_ratio) for pair in pairs), max(lasts)
        for _ in range(2):  # the cut-off depends on the full area, and that on the cut-off
            plateau = find_plateau(pooled, end, choked)
            # An area that leaves its plateau gives no curve; how far it is shown is judged by its largest part then.
            scale = pooled.area.max() if leaves_band(pooled, plateau) else plateau.area
            end = find_cut_off(pooled, max(lasts), scale)
            if end < pooled.knots[1]:
                wrong = f"too noisy: half the band of the area is nowhere below {MAX_HALF_BAND:.0%} of it"
                right = "give more tests, of less noise, higher pressure or a smaller vessel"
                raise InputError([Fault(", ".join(record.name for record in records), "pressure", wrong, right)])
        if not leaves_band(pooled, plateau):
            break
    vessel = stated
    refusal = _refusal(pooled, plateau)
    # Each test alone, and whether all say the same.
    fits = [fit_area(vessel, [part], pooled.knots, opened)[0] for part in parts] if len(parts) > 1 else [pooled]
    ends = [find_cut_off(fit, last, scale) for fit, last in zip(fits, lasts, strict=True)]
    collapse = collapse_of(fits, min(ends), plateau.area) if len(parts) > 1 and min(ends) > pooled.knots[1] else None
    noise = [noise_before(record)[0] for record in records]
    if refusal:
        curve, full_area, half = np.empty((0, 5)), nan, nan
    else:
        full_area, half = plateau.area, plateau.half_band
        if wall and wall.is_identified:  # the area that was found beside the conductance knows what both are worth
            full_area, half = wall.area, wall.area_half_band
        used = pooled if plateau.end >= end else cut(pooled, plateau.end)
        curve = opening_curve(used, plateau.start, full_area)
    result = Discharge(parts, noise, fits, ends, pooled, end, full_area, half, curve, collapse, [], wall, refusal)
    result.warnings.extend([refusal] if refusal else _area_warnings(result, plateau))
    result.warnings.extend(_warnings(result, vessel))
    result.warnings.extend(warning for record in records for warning in record.warnings)
    return result


def _refusal(fit: AreaFit, plateau: Plateau) -> str:
    """Why an area gives no curve; "" where it does."""
    if not leaves_band(fit, plateau):
        return ""
    last = int(np.searchsorted(fit.knots, plateau.end, side="right"))
    high, low = 1e6 * fit.area[1:last].max(), 1e6 * fit.area[plateau.start : last].min()
    return (
        f"no curve: the area comes to {high:.3g} mm², and is down to {low:.3g} mm² until {1e3 * plateau.end:.3g} ms. "
        "An open valve has one area: does it close again, does the vessel leak, are its volume and the zero of the "
        "pressure right? Cut the record before the valve closes, mend the leak, or fill the vessel with wire and say "
        "that it is isothermal"
    )


def _area_warnings(result: Discharge, plateau: Plateau) -> Iterator[str]:
    """What a user should know of an area that gives a curve."""
    if not 1.3 * result.curve[-1, 0] < result.end:
        yield "the area is reported for little longer than it rises: the full area may be larger; take a larger vessel"
    if plateau.end < result.end:
        fit = result.pooled
        beyond = (fit.knots > plateau.end) & (fit.knots <= result.end)
        level = float(np.average(fit.area[beyond], weights=fit.half_band[beyond] ** -2.0))
        yield (
            f"the area is that of the choked flow, until {1e3 * plateau.end:.3g} ms; later it seems to be "
            f"{1e6 * level:.3g} mm²: the critical pressure ratio of the valve is not that of a nozzle, or heat flows"
        )


def _warnings(result: Discharge, vessel: Vessel) -> Iterator[str]:
    """What a user should know."""
    if result.collapse and not result.collapse.agree:
        yield "the curves differ by more than their noise: check volume, pressures' zeros, temperature and time zero"
    for record, raw, noise in zip(result.records, result.noise, result.pooled.noise, strict=True):
        before = record.times <= 0.0
        expected = noise_before(record)[0]
        if noise > expected * (1.0 + 4.0 / np.sqrt(2.0 * before.sum())):
            yield f"{record.name}: what the fit leaves, {noise:.3g} Pa, is more than the noise before the switch"
        times, e = record.times[before], record.pressures[before]
        slope = np.polyfit(times - times.mean(), e, 1)[0]
        if abs(slope) * np.sqrt(np.sum((times - times.mean()) ** 2)) > 5.0 * max(expected, 1e-6 * e.mean()):
            yield f"{record.name}: the pressure drifts before the switch, by {slope / 1e3:.3g} kPa/s"
        if raw < 1e-6 * vessel.ambient_pressure:
            yield f"{record.name}: no noise before the switch: the band tells of the fit alone"


def figure_arrays(result: Discharge) -> dict[str, Any]:
    """Collect what a figure of discharge tests shows.

    ``tests``: of each its ``name``, ``time`` [s], ``pressure`` and ``fitted`` [Pa abs], and up to where it tells
    ``knots`` [s], ``area``, ``low`` and ``high`` [m2]; ``pooled``: the last four of all tests together; ``curve``: as
    `Discharge.curve`; ``full_area`` [m2], the largest area where there is none; ``cut_off`` [s].
    """

    def band(fit: AreaFit, end: float) -> dict[str, np.ndarray]:
        reported = fit.knots <= end
        low, high = fit.area - fit.half_band, fit.area + fit.half_band
        columns = {"knots": fit.knots, "area": fit.area, "low": low, "high": high}
        return {name: column[reported] for name, column in columns.items()}

    tests = [
        {"name": r.name, "time": r.times, "pressure": r.pressures, "fitted": fit.pressures[0]} | band(fit, end)
        for r, fit, end in zip(result.records, result.fits, result.ends, strict=True)
    ]
    pooled = band(result.pooled, result.end)
    return {
        "tests": tests,
        "pooled": pooled,
        "curve": result.curve,
        "full_area": pooled["area"].max() if result.refusal else result.full_area,
        "cut_off": result.end,
    }
