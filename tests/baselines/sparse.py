"""Sparse regression on smoothed derivatives (PySINDy): which force is missing from Eq. 1."""

import numpy as np
from pysindy import STLSQ, SmoothedFiniteDifference
from scipy.ndimage import binary_erosion

from apesim.studies.measured import FIT

WINDOW = 1.5e-3
"""Width of the smoothing cubic [s]."""
MOVING = 0.05
"""Speed from which the piston counts as under way [m/s]."""
THRESHOLD = 0.1
"""Root mean square of a term, over that of all, below which it is dropped."""


def library(x, v, a, pressed):
    """Forces that a missing effect could add, by its name; x is the piston's position."""
    return {
        "side_force": np.ones_like(x),
        "coulomb_friction": -np.sign(v),
        "quadratic_drag": -v * np.abs(v),
        "spring_rate_error": -(x - x.mean()),
        "moving_mass_error": -a,
        "seal_friction": -pressed * np.sign(v),
        "stribeck_friction": -np.exp(-((v / 0.1) ** 2)) * np.sign(v),
    }


def missing_force(machine, measured):
    """The term that weighs most in what Eq. 1 leaves, of the runs to fit.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    measured : apesim.studies.measured.Measured
        With lift and both chambers; no force can be had without.

    Returns
    -------
    list of (str, float)
        Names and root mean square force [N], the largest first; empty where nothing can be said.
    """
    valve, parts, forces = machine.valve, [], []
    for run in measured.of(FIT):
        if not {"lift", "pressure_a", "pressure_b"} <= set(run.channels) or measured.bench != "valve":
            return []
        step = float(np.median(np.diff(run.times)))
        n = max(5, 2 * int(0.5 * WINDOW / step) + 1)
        position = valve.stroke - run.channels["lift"]
        slope = SmoothedFiniteDifference(smoother_kws={"window_length": n, "polyorder": 3})
        v = slope(position[:, None], step)[:, 0]
        x, a = slope.smoothed_x_[:, 0], slope(v[:, None], step)[:, 0]
        p_a, p_b = run.channels["pressure_a"], run.channels["pressure_b"]
        moving = binary_erosion(np.abs(v) > MOVING, np.ones(2 * n + 5))  # away from the stops by what is smoothed
        force = valve.moving_mass * a - (p_a - p_b) * valve.piston_area
        force -= valve.spring_rate * (valve.stroke - 2.0 * x) - valve.viscous_friction * v
        pressed = np.abs(p_a - machine.ambient.pressure) + np.abs(p_b - machine.ambient.pressure)
        terms = library(x, v, a, pressed) | {"viscous friction": -v}
        parts.append(np.column_stack([term[moving] for term in terms.values()]))
        forces.append(force[moving])
    columns, target = np.vstack(parts), np.concatenate(forces)
    if len(target) < 2 * columns.shape[1]:
        return []
    size = np.sqrt(np.mean(columns**2, axis=0)) + 1e-30
    sparse = STLSQ(threshold=THRESHOLD * float(np.sqrt(np.mean(target**2))), alpha=0.0)
    shares = sparse.fit(columns / size, target[:, None]).coef_[0]
    found = sorted(zip(terms, shares, strict=True), key=lambda one: -abs(one[1]))
    return [(name, float(abs(share))) for name, share in found if share and name != "viscous friction"]
