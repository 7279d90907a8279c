"""Discharge tests evaluated: each alone, compared, pooled, and turned into a curve that the valve can be run with."""

from typing import Any, NamedTuple

import numpy as np

from apesim.quantities import Fault, InputError
from apesim.studies.discharge.area import AreaFit, fit_area
from apesim.studies.discharge.collapse import collapse_of
from apesim.studies.discharge.opening import WIDEST, opening_curve, plateau, told_until
from apesim.studies.discharge.records import MIN_RATIO, fitted_part, noise_before

CUT_OFF = f"told while p > {MIN_RATIO:g} p_ambient and half the 95 % band is below {WIDEST:.0%} of the full area"
METHOD = (
    "S(t), straight between knots, through Eq. 10 forward to all samples; a random walk of the largest marginal "
    "likelihood, undersmoothed; noise from before the switch and from what is left; 95 % point-wise with the bias of "
    "smoothing"
)
HEADER = ("time [ms]", "opening [-]", "effective_area [mm^2]", "low [mm^2]", "high [mm^2]")


class Discharge(NamedTuple):
    """What discharge tests say of a valve."""

    records: list
    """The tests as fitted, `Record`: down to `MIN_RATIO`, long ones averaged to at most `MAX_SAMPLES`."""
    noise: list
    """Standard deviation of single samples before the valve is switched, by test [Pa]."""
    fits: list
    """Fit of each test alone, `AreaFit`."""
    ends: list
    """Until when each test tells [s]."""
    pooled: AreaFit
    end: float
    """Until when all tests together tell [s]."""
    full_area: float
    """Effective area of the open valve [m2]."""
    full_area_half_band: float
    """[m2]"""
    curve: np.ndarray
    """Time [s], opening, effective area and ends of its band [m2], shape (m, 5)."""
    collapse: Any
    """`Collapse`; None of a single test."""
    warnings: list


def discharge(vessel, records):
    """The effective area of a valve over the time after its switch, from discharge tests.

    Parameters
    ----------
    vessel : Vessel
    records : sequence of Record
        As `read_test` gives them.

    Returns
    -------
    Discharge

    Raises
    ------
    InputError
        The tests are too noisy to tell anything.
    """
    parts = [fitted_part(record, vessel.ambient_pressure) for record in records]
    pooled, opened = fit_area(vessel, parts)
    lasts = [part.times[-1] for part in parts]
    end = max(lasts)
    for _ in range(2):  # what is told depends on the full area, and that on what is told
        start, full_area, half = plateau(pooled, end)
        end = told_until(pooled, max(lasts), full_area)
        if end < pooled.knots[1]:
            wrong = f"too noisy: half the band of the area is nowhere below {WIDEST:.0%} of it"
            right = "give more tests, of less noise, higher pressure or a smaller vessel"
            raise InputError([Fault(", ".join(record.name for record in records), "pressure", wrong, right)])
    fits = [fit_area(vessel, [part], pooled.knots, opened)[0] for part in parts] if len(parts) > 1 else [pooled]
    ends = [told_until(fit, last, full_area) for fit, last in zip(fits, lasts, strict=True)]
    collapse = collapse_of(fits, min(ends), full_area) if len(parts) > 1 and min(ends) > pooled.knots[1] else None
    noise = [noise_before(record)[0] for record in records]
    curve = opening_curve(pooled, start, full_area)
    found = Discharge(parts, noise, fits, ends, pooled, end, full_area, half, curve, collapse, [])
    found.warnings.extend(_warnings(found, vessel))
    return found


def _warnings(found, vessel):
    """What a user should know."""
    if not 1.3 * found.curve[-1, 0] < found.end:
        yield "the area is hardly told for longer than it rises: the full area may be larger; take a larger vessel"
    if found.collapse and not found.collapse.agree:
        yield "the curves differ by more than their noise: check volume, pressures' zeros, temperature and time zero"
    for record, raw, left in zip(found.records, found.noise, found.pooled.noise, strict=True):
        before = record.times <= 0.0
        expected = noise_before(record)[0]
        if left > expected * (1.0 + 4.0 / np.sqrt(2.0 * before.sum())):
            yield f"{record.name}: what the fit leaves, {left:.3g} Pa, is more than the noise before the switch"
        times, e = record.times[before], record.pressures[before]
        slope = np.polyfit(times - times.mean(), e, 1)[0]
        if abs(slope) * np.sqrt(np.sum((times - times.mean()) ** 2)) > 5.0 * max(expected, 1e-6 * e.mean()):
            yield f"{record.name}: the pressure drifts before the switch, by {slope / 1e3:.3g} kPa/s"
        if raw < 1e-6 * vessel.ambient_pressure:
            yield f"{record.name}: no noise before the switch: the band tells of the fit alone"


def figure_arrays(found):
    """What a figure of discharge tests shows.

    Parameters
    ----------
    found : Discharge

    Returns
    -------
    dict
        ``tests``: of each its ``name``, ``time`` [s], ``pressure`` and ``fitted`` [Pa abs], and up to where it tells
        ``knots`` [s], ``area``, ``low`` and ``high`` [m2]; ``pooled``: the last four of all tests together; ``curve``:
        as `Discharge.curve`; ``full_area`` [m2]; ``cut_off`` [s].
    """

    def band(fit, end):
        told = fit.knots <= end
        low, high = fit.area - fit.half_band, fit.area + fit.half_band
        columns = {"knots": fit.knots, "area": fit.area, "low": low, "high": high}
        return {name: column[told] for name, column in columns.items()}

    tests = [
        {"name": r.name, "time": r.times, "pressure": r.pressures, "fitted": fit.pressures[0]} | band(fit, end)
        for r, fit, end in zip(found.records, found.fits, found.ends, strict=True)
    ]
    pooled = band(found.pooled, found.end)
    return {
        "tests": tests,
        "pooled": pooled,
        "curve": found.curve,
        "full_area": found.full_area,
        "cut_off": found.end,
    }
