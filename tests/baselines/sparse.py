"""Sparse regression on smoothed derivatives (SINDy by thresholded least squares): which force is missing from Eq. 1."""

import numpy as np
from scipy.signal import savgol_filter

from studies.measured import FIT

WINDOW = 1.5e-3
"""Of the smoothing cubic [s]."""
MOVING = 0.05
"""Speed from which the piston counts as under way [m/s]."""
THRESHOLD = 0.1
"""Of a term's share in the largest, below which it is dropped."""
ROUNDS = 10


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
    machine : engine.machine.Machine
    measured : studies.measured.Measured
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
        x, v, a = (savgol_filter(position, n, 3, deriv, step) for deriv in range(3))
        p_a, p_b = run.channels["pressure_a"], run.channels["pressure_b"]
        inner = 2.0 * n * step * MOVING
        moving = (np.abs(v) > MOVING) & (x > inner) & (x < valve.stroke - inner)
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
    kept = np.ones(columns.shape[1], dtype=bool)
    shares = np.zeros(columns.shape[1])
    for _ in range(ROUNDS):
        shares[:] = 0.0
        shares[kept] = np.linalg.lstsq(columns[:, kept] / size[kept], target, rcond=None)[0]
        kept = np.abs(shares) > THRESHOLD * np.abs(shares).max()
    found = sorted(zip(terms, shares, strict=True), key=lambda one: -abs(one[1]))
    return [(name, float(abs(share))) for name, share in found if share and name != "viscous friction"]
