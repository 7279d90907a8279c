"""Discharge tests of a solenoid valve: read, pooled, compared, and turned into a curve that the valve can be run with.

A vessel empties through the valve to atmosphere. A test is a CSV with the columns ``time [ms]``, 0 as the valve is
switched, and ``pressure [kPa abs]``, in any units; the pressure says whether it is gauge or absolute. Inside, all is
absolute: Eq. 10 of doi 10.1631/jzus.A0820373 with gauge pressures is silently wrong. The law and the fit stand in
`studies.effective_area`.

A test tells nothing below `LEAST_RATIO` times ambient, where an error of the pressure's zero weighs too much; and
nothing once half the band is wider than `WIDEST` of the area at full opening.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from apesim.quantities import Culprit, InputError
from studies.columns import read_columns
from studies.effective_area import DEVIATIONS, AreaFit, Record, fit_area, monotone, noise_before

COLUMNS = {"time": "ms", "pressure": "kPa abs"}
FEWEST_BEFORE, FEWEST_AFTER = 10, 20
MOST_SAMPLES = 4000
LEAST_RATIO = 1.1
WIDEST = 0.2
CUT_OFF = f"told while p > {LEAST_RATIO:g} p_ambient and half the 95 % band is below {WIDEST:.0%} of the full area"
METHOD = (
    "S(t), straight between knots, through Eq. 10 forward to all samples; a random walk of the largest marginal "
    "likelihood, undersmoothed; noise from before the switch and from what is left; 95 % point-wise with the bias of "
    "smoothing"
)
HEADER = ("time [ms]", "opening [-]", "effective_area [mm^2]", "low [mm^2]", "high [mm^2]")


class Collapse(NamedTuple):
    """How well the curves of several tests fall on one another, where all of them tell."""

    rms: float
    """Of the deviations from their mean, over the full area."""
    largest_spread: float
    """Between the highest and the lowest, over the full area."""
    expected_spread: float
    """What the noise alone makes of the largest spread, 95 %, over the full area."""
    within_bands: float
    """Share of points at which two curves differ by less than their bands allow, over all pairs; 95 % is due."""
    agree: bool
    """Whether no two differ anywhere by more than the noise does in 95 % of cases (simultaneous)."""


class Discharge(NamedTuple):
    """What discharge tests say of a valve."""

    records: list
    """The tests as fitted, `Record`: down to `LEAST_RATIO`, long ones averaged to at most `MOST_SAMPLES`."""
    noise: list
    """Of single samples before the valve is switched, by test [Pa]."""
    fits: list
    """Of each test alone, `AreaFit`."""
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


def read_test(path, ambient_pressure):
    """Read a discharge test.

    Parameters
    ----------
    path : path
    ambient_pressure : float
        What gauge pressures stand above [Pa].

    Returns
    -------
    Record

    Raises
    ------
    InputError
        With a culprit for each fault.
    """
    path, right = Path(path), 'give a CSV with the header "time [ms],pressure [kPa abs]"'
    columns, _, culprits = read_columns(path, COLUMNS, COLUMNS, ambient_pressure, right)
    if not culprits:
        culprits = [Culprit(str(path), *fault) for fault in _faults(**columns, ambient_pressure=ambient_pressure)]
    if culprits:
        raise InputError(culprits)
    return Record(path.name, columns["time"], columns["pressure"])


def _faults(time, pressure, ambient_pressure):
    """Key, fault and right form of columns that can be no discharge test."""
    before, after = int(np.sum(time <= 0.0)), int(np.sum(time > 0.0))
    if before < FEWEST_BEFORE or after < FEWEST_AFTER:
        right = f"give at least {FEWEST_BEFORE} until t = 0, which tell the noise, and {FEWEST_AFTER} after it"
        yield "time", f"{before} rows until the valve is switched at t = 0, {after} after it", right
        return
    kilo, start = ambient_pressure / 1e3, pressure[time <= 0.0]
    low = ambient_pressure - max(0.03 * ambient_pressure, 6.0 * start.std())
    if start.mean() < LEAST_RATIO**2 * ambient_pressure:
        wrong = f"starts at {start.mean() / 1e3:.4g} kPa abs, not well above the ambient {kilo:.4g} kPa abs"
        yield "pressure", wrong, 'fill the vessel higher; or is it gauge? then write "pressure [kPa gauge]"'
    elif pressure.min() < low:
        wrong = f"falls to {pressure.min() / 1e3:.4g} kPa abs, below the ambient {kilo:.4g} kPa abs"
        yield "pressure", wrong, 'is it gauge? then write "pressure [kPa gauge]"; else set ambient.pressure'
    elif start.mean() - pressure[-after // 10 :].mean() < max(5.0 * start.std(), 0.02 * (start.mean() - low)):
        yield "pressure", "does not fall after t = 0", "let t = 0 be the switching command, and record the discharge"


def fitted_part(record, ambient_pressure):
    """The samples of a test while it is well above ambient, neighbours averaged where there are very many."""
    width = max(5, len(record.times) // 200)
    smooth = np.convolve(np.pad(record.pressures, width // 2, mode="edge"), np.ones(width) / width, mode="valid")
    low = (smooth[: len(record.times)] < LEAST_RATIO * ambient_pressure) & (record.times > 0.0)
    end = int(np.argmax(low)) if low.any() else len(low)
    group = -(-end // MOST_SAMPLES)
    whole = end // group * group
    averaged = (column[:whole].reshape(-1, group).mean(axis=1) for column in record[1:])
    return Record(record.name, *averaged)


def told_until(fit, last, full_area):
    """Until when an area is told [s]: by half its band, and by the pressure, which is too low after `last` [s]."""
    told = np.flatnonzero((fit.half_band <= WIDEST * max(full_area, 0.0)) & (fit.knots <= last))
    return float(fit.knots[told[-1]])


def plateau(fit, end):
    """From where on the area is constant within its bands.

    Parameters
    ----------
    fit : AreaFit
    end : float
        Until when the area is told [s].

    Returns
    -------
    start : int
        The first knot at the mean of what follows, after one from which on nine of ten bands (else eight)
        hold that mean.
    mean, half_band : float
        Weighted by the bands [m2].
    """
    last = int(np.searchsorted(fit.knots, end, side="right"))

    def mean_from(start):
        weights = 1.0 / fit.half_band[start:last] ** 2
        weights /= weights.sum()
        return weights @ fit.area[start:last], weights

    half = max(2, int(np.searchsorted(fit.knots, end / 2.0)))
    searches = [(share, start) for share, to in ((0.9, half), (0.8, half), (0.9, last)) for start in range(1, to)]
    for share, start in searches:  # the second half of what is told, only if the first has no such knot
        mean, weights = mean_from(start)
        if np.mean(np.abs(fit.area[start:last] - mean) <= fit.half_band[start:last]) >= share:
            break
    start += int(np.argmax(fit.area[start:last] >= mean))  # the first of them may still rise
    mean, weights = mean_from(start)
    variance = weights @ fit.covariance[start:last, start:last] @ weights
    return start, float(mean), float(DEVIATIONS * np.sqrt(variance))


def opening_curve(fit, start, full_area):
    """The area made monotone (isotonic regression, weighted by the band), over the full area, and trimmed.

    Parameters
    ----------
    fit : AreaFit
    start : int
        First knot of the plateau, from which on the opening is 1. It is 0 up to the last one before at which the area
        is not positive.
    full_area : float
        [m2]

    Returns
    -------
    (m, 5) float array
        Time [s], opening from 0 to 1, effective area, low and high end of its band [m2].
    """
    first = int(np.flatnonzero(fit.area[:start] <= 0.0)[-1])
    area = np.append(0.0, monotone(fit.area[1:], fit.half_band[1:]))
    opening = np.minimum(area / full_area, 1.0)
    opening[: first + 1], opening[start:] = 0.0, 1.0
    kept = slice(first, int(np.argmax(opening == 1.0)) + 1)
    area = opening * full_area
    low, high = (np.clip(fit.area + sign * fit.half_band, 0.0, None) for sign in (-1.0, 1.0))
    columns = fit.knots, opening, area, np.minimum(low, area), np.maximum(high, area)
    return np.column_stack([column[kept] for column in columns])


def collapse_of(fits, end, full_area):
    """How well the curves of several tests, at the same knots, fall on one another.

    Parameters
    ----------
    fits : sequence of AreaFit
    end : float
        Until when all of them tell [s].
    full_area : float
        [m2]

    Returns
    -------
    Collapse
    """
    part = slice(1, int(np.searchsorted(fits[0].knots, end, side="right")))
    curves, halves = (np.stack([getattr(fit, name)[part] for fit in fits]) for name in ("area", "half_band"))
    random = np.random.default_rng(0)
    noise = []
    for fit in fits:
        values, vectors = np.linalg.eigh(fit.covariance[part, part])
        factor = vectors * np.sqrt(np.clip(values, 0.0, None))
        noise.append(random.standard_normal((1000, len(values))) @ factor.T)
    deviations = [np.sqrt(np.diag(fit.covariance)[part]) for fit in fits]
    pairs = [(i, j) for i in range(len(fits)) for j in range(i)]
    drawn, within, largest = np.zeros(1000), [], 0.0
    for i, j in pairs:
        both = np.hypot(deviations[i], deviations[j])
        drawn = np.maximum(drawn, np.max(np.abs(noise[i] - noise[j]) / both, axis=1))
        wide = np.hypot(halves[i], halves[j])
        within.append(np.abs(curves[i] - curves[j]) <= wide)
        largest = max(largest, np.max(np.abs(curves[i] - curves[j]) / wide) * DEVIATIONS)
    spreads = np.ptp(np.stack(noise), axis=0).max(axis=1)
    return Collapse(
        float(np.sqrt(np.mean((curves - curves.mean(axis=0)) ** 2)) / full_area),
        float(np.ptp(curves, axis=0).max() / full_area),
        float(np.quantile(spreads, 0.95) / full_area),
        float(np.mean(within)),
        bool(largest <= np.quantile(drawn, 0.95)),
    )


def discharge(vessel, records):
    """The effective area of a valve over the time after its switch, from discharge tests.

    Parameters
    ----------
    vessel : studies.effective_area.Vessel
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
            raise InputError([Culprit(", ".join(record.name for record in records), "pressure", wrong, right)])
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
