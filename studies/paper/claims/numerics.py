"""How the paper computes: its fixed step, and the evaluation function of its fit (Eq. 11)."""

from typing import Any

import numpy as np

from apesim.engine.machine import Machine
from apesim.march.adaptive import EVENTS
from apesim.march.hybrid_system import events, handle_event, rates, start_segment
from apesim.studies.limit.valve_map import PULSE
from apesim.studies.paper.claims.claim import Claim, verdict_of
from apesim.studies.paper.claims.design import MEASURED
from apesim.studies.paper.claims.stroke import HIGH
from apesim.studies.run.operating_conditions import with_control_air
from apesim.valve.bench import bench_of, closed_at_start, run_bench
from apesim.valve.motion import MET_OPEN

STEP = 0.01e-3
"""Step of the paper's Runge-Kutta method [s]."""
SAMPLES = (0.1e-3, 0.05e-3)
"""Times between two samples of lift, for Eq. 11 [s]."""
STIFFER = 1.1
"""Factor on the viscous friction, for a lift that differs."""


def fixed_step_opening(machine: Machine, step: float) -> tuple[float, float, float]:
    """March an opening stroke by Runge-Kutta of order 4 with a fixed step [s], events met to a step.

    The paper names the order and the step of 0.01 ms (EPV, doi 10.1631/jzus.A0820373); the method is taken for the
    classical one (Hairer, Norsett and Wanner 1993, section II.1, doi 10.1007/978-3-540-78862-1). Returns delay [s],
    stroke time [s] and seating speed [m/s]; NaN where the piston does not arrive.

    >>> delay, stroke_time, seating_speed = fixed_step_opening(Machine(), 0.05e-3)
    >>> f"{1e3 * delay:.1f} ms, {1e3 * stroke_time:.1f} ms, {seating_speed:.1f} m/s"
    '5.8 ms, 6.1 ms, 1.5 m/s'
    """
    p, tables = bench_of(machine, [0.0, PULSE])
    y, mode = closed_at_start(p)
    k, g, stroke = np.zeros((4, len(y))), np.full(EVENTS, -1.0), machine.valve.stroke
    t, delay = 0.0, np.nan
    for breakpoint in tables.breakpoints(0.0, PULSE):
        start_segment(p, tables, t, breakpoint, y, mode)
        steps = max(1, round((breakpoint - t) / step))
        h = (breakpoint - t) / steps
        for _ in range(steps):
            rates(p, t, y, mode, k[0])
            rates(p, t + 0.5 * h, y + 0.5 * h * k[0], mode, k[1])
            rates(p, t + 0.5 * h, y + 0.5 * h * k[1], mode, k[2])
            rates(p, t + h, y + h * k[2], mode, k[3])
            y = y + h / 6.0 * (k[0] + 2.0 * (k[1] + k[2]) + k[3])
            t += h
            if np.isnan(delay) and y[0] < 0.99 * stroke:
                delay = t
            events(p, t, y, mode, g)
            for event in np.flatnonzero(g > 0.0):
                if event == MET_OPEN:
                    return delay, t - delay, abs(y[1])
                handle_event(p, tables, event, t, y, mode)
    return delay, np.nan, np.nan


def fixed_step(machine: Machine) -> Claim:
    """Judge the paper's Runge-Kutta of order 4 with a step of 0.01 ms by the march with located events.

    The paper names them in [EPV, section on simulation setting and experimental validation].
    """
    errors = []
    for pressure in (*MEASURED, HIGH / 1e6):
        supplied = with_control_air(machine, machine.ambient.pressure + pressure * 1e6, 287.0)
        stroke: Any = run_bench(supplied, PULSE).opening
        fixed = np.array(fixed_step_opening(supplied, STEP))
        errors.append(fixed / np.array([stroke.delay, stroke.stroke_time, stroke.seating_speed]) - 1.0)
    largest = np.abs(errors).max(axis=0)
    shares = ", ".join(f"{100 * share:.2f} %" for share in largest)
    return Claim(
        "fixed_step",
        "simulation setting",
        "Runge-Kutta of order 4 with a fixed step of 0.01 ms is enough to calculate the equations.",
        "0.01 ms",
        f"against located events, delay time, stroke time and seating speed are off by up to {shares}",
        dict(zip(("delay_error", "stroke_time_error", "seating_speed_error"), largest, strict=True)),
        verdict_of(np.all(largest < 0.01)),
        f"At {', '.join(f'{p:g}' for p in (*MEASURED, HIGH / 1e6))} MPa, 287 K; judged by 1 %. The times are off "
        "because contacts are met to a step only.",
    )


def evaluation_function(machine: Machine) -> Claim:
    """Judge [EPV, Eq. 11], which falls with the number of samples, as n - 1 stands outside the root."""
    supplied = with_control_air(machine, machine.ambient.pressure + 0.4e6, 287.0)
    valve = supplied.valve
    other = supplied._replace(valve=valve._replace(viscous_friction=STIFFER * valve.viscous_friction))
    printed, rms = [], []
    for sample in SAMPLES:
        difference = (
            run_bench(other, PULSE, sample=sample).trace[:, 0] - run_bench(supplied, PULSE, sample=sample).trace[:, 0]
        )
        n, squares = len(difference), np.sum(difference**2)
        printed.append(np.sqrt(squares) / (n - 1) * 1e3)
        rms.append(np.sqrt(squares / (n - 1)) * 1e3)
    ratio = printed[1] / printed[0]
    return Claim(
        "evaluation_function",
        "Eq. 11",
        "The evaluation function of Eq. 11 says how far simulated and measured lift differ.",
        "1/(n - 1) times the root of the sum of squares",
        f"two curves of the same lifts, sampled every {SAMPLES[0] * 1e3:g} and {SAMPLES[1] * 1e3:g} ms, differ by "
        f"{printed[0]:.4f} and {printed[1]:.4f} mm by Eq. 11, by {rms[0]:.4f} and {rms[1]:.4f} mm root mean square",
        {"eq_11_mm_coarse": printed[0], "eq_11_mm_fine": printed[1], "rms_mm_coarse": rms[0], "rms_mm_fine": rms[1]},
        verdict_of(abs(ratio - 1.0) < 0.01),
        "Eq. 11 is no root mean square: n - 1 stands outside the root, so it falls as 1/sqrt(n). The friction that "
        "fits one run best is the same, but values of runs of unlike length or rate do not compare. Judged by 1 %; the "
        f"lifts are those at 0.40 MPa and with {STIFFER:g} times the friction.",
    )
