"""The map of corrected commands as a C header that a controller can use."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from apesim.archive import sha256
from apesim.engine.angles import DEGREE, TURN
from apesim.studies.archives.pressure_axes import PRESSURE_AXES
from apesim.studies.timing.table import InterpolationError

if TYPE_CHECKING:
    from apesim.studies.timing.grid import TimingMap

HEADER = """\
/* Command angles of an electro-pneumatic intake valve, so that it really opens and closes at its targets.
 *
 * targets            opening {open_target:.9g} deg, closing {close_target:.9g} deg after top dead centre
 * made by            apesim engine timing, doi 10.1631/jzus.A0820373 and the engine's own balances
 * machine            SHA-256 of its TOML text {machine}
 * axes               speed [r/min], {pressure} [Pa abs], supply temperature [K]{other}
 * advance            target less command angle [deg]; 0 where unreachable
 * interpolation      linear along each axis between neighbours x[i] and x[i + 1], s = (x - x[i]) / (x[i + 1] - x[i]):
 *                    y = (1 - s) y[i] + s y[i + 1], in three axes the sum over eight corners
 * error of angles    of the command angles, interpolated less solved, {error}.
 *                    {valve}
 *
 * ISO C99, no library. apesim_timing() sets both command angles [deg] and returns
 * APESIM_FULL_LIFT, where the piston meets its open stop at all points around; or
 * APESIM_PART_LIFT, where at one of them the valve meets its targets but turns back before that stop. It returns
 * APESIM_UNREACHABLE and sets nothing outside the axes and beside a point that is unreachable. Limit its arguments to
 * the axes if that is what you want.
 */
#ifndef APESIM_TIMING_H
#define APESIM_TIMING_H

#define APESIM_UNREACHABLE 0
#define APESIM_FULL_LIFT 1
#define APESIM_PART_LIFT 2

#define APESIM_OPEN_TARGET_DEG ({open_target:.9g})
#define APESIM_CLOSE_TARGET_DEG ({close_target:.9g})
#define APESIM_SPEEDS {i}
#define APESIM_PRESSURES {j}
#define APESIM_TEMPERATURES {k}

static const double apesim_speed[APESIM_SPEEDS] = {{ /* r/min */
{speeds}
}};
static const double apesim_pressure[APESIM_PRESSURES] = {{ /* Pa abs */
{pressures}
}};
static const double apesim_temperature[APESIM_TEMPERATURES] = {{ /* K */
{temperatures}
}};

/* [speed][pressure][temperature]: APESIM_UNREACHABLE, APESIM_FULL_LIFT or APESIM_PART_LIFT */
static const unsigned char apesim_stroke[APESIM_SPEEDS][APESIM_PRESSURES][APESIM_TEMPERATURES] = {{
{stroke}
}};

/* [speed][pressure][temperature], deg */
static const double apesim_advance[APESIM_SPEEDS][APESIM_PRESSURES][APESIM_TEMPERATURES] = {{
{advance}
}};

/* [speed][pressure][temperature], deg */
static const double apesim_release_advance[APESIM_SPEEDS][APESIM_PRESSURES][APESIM_TEMPERATURES] = {{
{release_advance}
}};

static int apesim_place(const double *axis, int points, double x, int *low, double *share)
{{
    *low = 0;
    *share = 0.0;
    if (!(x >= axis[0] && x <= axis[points - 1]))
        return 0;
    while (*low + 2 < points && x >= axis[*low + 1])
        ++*low;
    if (points > 1)
        *share = (x - axis[*low]) / (axis[*low + 1] - axis[*low]);
    return 1;
}}

static int apesim_timing(double speed, double pressure, double temperature, double *energise_deg, double *release_deg)
{{
    int i, j, k, corner, stroke = APESIM_FULL_LIFT;
    double s, p, t, energise = APESIM_OPEN_TARGET_DEG, release = APESIM_CLOSE_TARGET_DEG;
    if (!apesim_place(apesim_speed, APESIM_SPEEDS, speed, &i, &s) ||
        !apesim_place(apesim_pressure, APESIM_PRESSURES, pressure, &j, &p) ||
        !apesim_place(apesim_temperature, APESIM_TEMPERATURES, temperature, &k, &t))
        return APESIM_UNREACHABLE;
    for (corner = 0; corner < 8; ++corner) {{
        const int a = corner >> 2, b = corner >> 1 & 1, c = corner & 1;
        const double weight = (a ? s : 1.0 - s) * (b ? p : 1.0 - p) * (c ? t : 1.0 - t);
        if (weight > 0.0) {{
            if (apesim_stroke[i + a][j + b][k + c] == APESIM_UNREACHABLE)
                return APESIM_UNREACHABLE;
            if (apesim_stroke[i + a][j + b][k + c] == APESIM_PART_LIFT)
                stroke = APESIM_PART_LIFT;
            energise -= weight * apesim_advance[i + a][j + b][k + c];
            release -= weight * apesim_release_advance[i + a][j + b][k + c];
        }}
    }}
    *energise_deg = energise;
    *release_deg = release;
    return stroke;
}}

#endif
"""


VALVE_ERROR = "How far the valve then misses its targets was not measured; its closing depends on both commands."


def error_text(error: InterpolationError) -> str:
    """Write what is known of the error of the interpolated command angles, in a sentence.

    It has the largest and rms errors at the centres of cells [deg], or why there are none.

    >>> error_text(InterpolationError(0, 4, 0, np.nan, np.nan, np.nan, np.nan))
    'not measured: no centre of a cell is reachable on both sides'
    >>> error_text(InterpolationError(4, 4, 0, 0.0020, 0.0010, 0.0030, 0.0015)).partition(") ")[2]
    'up to 0.115 deg (energise), 0.172 (release), rms 0.0573 and 0.0859'
    """
    if not error.centres:
        return "none, as it has one point only"
    if not error.points:
        return "not measured: no centre of a cell is reachable on both sides"
    where = "" if error.points == error.centres else f"{error.points} of {error.centres}, seed {error.seed}; "
    largest = f"{error.max_advance_error / DEGREE:.3g} deg (energise), {error.max_release_error / DEGREE:.3g} (release)"
    rms = f"rms {error.advance_error_rms / DEGREE:.3g} and {error.release_error_rms / DEGREE:.3g}"
    return f"at the centres of cells ({where}elsewhere it is not measured) up to {largest}, {rms}"


def c_header(timing_map: TimingMap) -> str:
    """Write a map of corrected commands as a C header, with a function that interpolates in it.

    It is ISO C99 that needs no library.
    """
    axes, command = timing_map.axes, timing_map.command
    i, j, k = axes.shape
    reachable = ~np.isnan(timing_map.advance)
    return HEADER.format(
        pressure=timing_map.pressure_axis.replace("_", " "),
        other=_other_pressure(timing_map),
        open_target=command.open_target / DEGREE,
        close_target=command.close_target / DEGREE,
        machine=sha256(timing_map.archive.machine),
        error=error_text(timing_map.error),
        valve=VALVE_ERROR,
        i=i,
        j=j,
        k=k,
        speeds=_row(axes.speeds / TURN * 60.0),
        pressures=_row(axes.pressures),
        temperatures=_row(axes.temperatures),
        stroke=_block(np.where(reachable, np.where(timing_map.full_lift, 1, 2), 0)),
        advance=_block(np.where(reachable, timing_map.advance / DEGREE, 0.0)),
        release_advance=_block(np.where(reachable, timing_map.release_advance / DEGREE, 0.0)),
    )


def _other_pressure(timing_map: TimingMap) -> str:
    """Line of the header on the pressure that is none of its axes, where the whole map has one."""
    columns, axis = timing_map.archive.variables, timing_map.pressure_axis
    (other,) = set(PRESSURE_AXES) - {axis}
    if not {axis, other} <= columns.keys():
        return ""
    values = columns[other].values
    if len(np.unique(values)) != 1 or np.array_equal(values, columns[axis].values):
        return ""
    return f"\n * at                 {other.replace('_', ' ')} {values[0]:.9g} Pa abs"


def _row(values: Iterable[float]) -> str:
    """Numbers of a row, with commas."""
    return "    " + ", ".join(f"{value:.12g}" for value in values)


def _block(values: np.ndarray) -> str:
    """Initialiser of an array with three axes, in braces."""
    planes = [",\n".join(f"     {{{_row(row).strip()}}}" for row in plane).strip() for plane in values]
    return ",\n".join(f"    {{{plane}}}" for plane in planes)
