"""What the paper puts into its equations: gauge pressures, the exponents of Eq. 10, the sign of the outflow."""

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.discharge import Discharge
from apesim.studies.discharge.vessel import effective_area
from apesim.studies.limit.valve_map import PULSE
from apesim.studies.paper.claims.claim import Claim, verdict_of
from apesim.studies.paper.discharge import AFTER, GAUGE, emptied, vessel_of
from apesim.valve.bench import run_bench
from apesim.valve.solenoid import opening_curve

FINE = 100e3
"""Samples a second of a discharge without noise, to be differentiated."""


class Emptying:
    """A vessel that empties from `gauge` [Pa gauge] through the model's open solenoid, without noise.

    Its arrays are over the same times.
    """

    def __init__(self, machine: Machine, gauge: float) -> None:
        self.vessel = vessel_of(machine)
        self.start = self.vessel.ambient_pressure + gauge
        opened = opening_curve(machine.valve.solenoid)[-1, 0]
        times = np.arange(0.0, opened + AFTER, 1.0 / FINE)
        pressures = emptied(machine, self.vessel, self.start, times)
        part = times > opened + 2.0 / FINE
        self.pressures, self.slopes = pressures[part][:-1], np.gradient(pressures, times)[part][:-1]


def gauge_pressures(machine: Machine) -> Claim:
    """Judge the claim that the pressures are gauge [EPV, text on Figs. 2, 3]; Eqs. 7 to 10 need absolute ones.

    >>> claim = gauge_pressures(Machine())
    >>> print(claim.verdict, f"{claim.values['error_gauge_at_start']:+.0%}")
    contradicted +27%
    """
    test, area = Emptying(machine, GAUGE[0]), machine.valve.solenoid.effective_area
    ambient = test.vessel.ambient_pressure
    right = effective_area(test.vessel, test.start, test.pressures, test.slopes) / area - 1.0
    blind = test.vessel._replace(ambient_pressure=0.0)
    wrong = effective_area(blind, test.start - ambient, test.pressures - ambient, test.slopes) / area - 1.0
    return Claim(
        "gauge_pressures",
        "Eqs. 7-10, Figs. 3-4",
        "The pressures p_i and p_ini of Eqs. 9 and 10 are given relative to ambient.",
        "relative",
        f"from a vessel that mass and energy balance empty from {GAUGE[0] / 1e6:g} MPa gauge, Eq. 10 gives the area "
        f"back within {np.abs(right).max():.0e} with absolute pressures; with gauge ones it is {wrong[0]:+.0%} off as "
        f"the valve is open, {wrong[-1]:+.0%} at {test.pressures[-1] / 1e6:.2f} MPa abs",
        {
            "largest_error_absolute": np.abs(right).max(),
            "error_gauge_at_start": wrong[0],
            "error_gauge_at_end": wrong[-1],
            "pressure_at_start_Pa": test.pressures[0],
            "pressure_at_end_Pa": test.pressures[-1],
        },
        verdict_of(np.abs(wrong).max() < 0.01),
        "Judged by 1 %. apesim takes absolute pressures only.",
    )


def exponents_of_eq_10(machine: Machine) -> Claim:
    """Judge the exponents of the pressures in [EPV, Eq. 10] by vessels that are emptied without it.

    >>> print(exponents_of_eq_10(Machine()).ours)
    -1.1429 and 0.1429
    """
    rows, falls = [], []
    for gauge in GAUGE:
        test = Emptying(machine, gauge)
        choked = test.vessel.ambient_pressure < test.vessel.gas.critical_ratio * test.pressures
        p = np.log(test.pressures[choked])
        rows.append(np.column_stack((np.ones_like(p), p, np.full_like(p, np.log(test.start)))))
        falls.append(np.log(-test.slopes[choked]))
    coefficients = np.linalg.lstsq(np.concatenate(rows), np.concatenate(falls))[0]
    k = test.vessel.gas.heat_capacity_ratio
    ours, printed = -coefficients[1:], np.array([(1.0 - 3.0 * k) / (2.0 * k), (k - 1.0) / (2.0 * k)])
    return Claim(
        "exponents_of_eq_10",
        "Eq. 10",
        "The effective area goes with p_i to (1-3k)/(2k) and p_ini to (k-1)/(2k).",
        f"{printed[0]:.4f} and {printed[1]:.4f}",
        f"{ours[0]:.4f} and {ours[1]:.4f}",
        {"of_pressure": ours[0], "of_initial_pressure": ours[1]},
        verdict_of(np.abs(ours - printed).max() < 0.01),
        "From the pressures of vessels that mass and energy balance empty from 0.4, 0.6 and 0.8 MPa gauge, while the "
        "flow is choked; judged by 0.01.",
    )


def curves_collapse(tests: Discharge) -> Claim:
    """Judge the claim that S(t) from several initial pressures is approximately the same [EPV, Fig. 4].

    `tests` are the model's own discharge tests.
    """
    collapse = tests.collapse
    if collapse is None:
        raise ValueError("curves of several tests are compared; give at least two")
    return Claim(
        "areas_collapse",
        "Fig. 4",
        "The effective area over time is approximately the same from 0.4, 0.6 and 0.8 MPa.",
        "approximately the same",
        f"rms of the differences from their mean {collapse.rms:.1%} of the full area, largest spread "
        f"{collapse.largest_spread:.1%}, by noise alone up to {collapse.expected_spread:.1%}",
        {
            "rms": collapse.rms,
            "largest_spread": collapse.largest_spread,
            "expected_spread": collapse.expected_spread,
            "within_bands": collapse.within_bands,
        },
        verdict_of(collapse.agree),
        "Of the model's own discharge tests, with noise; the paper's measured ones survive as a figure only.",
    )


def sign_of_outflow(machine: Machine) -> Claim:
    """Judge the sign in [EPV, Eq. 4], which adds dm_out."""
    run = run_bench(machine, PULSE)
    valve, r = machine.valve, vessel_of(machine).gas.gas_constant
    lift, _, *states = run.trace[[0, -1]].T
    volumes = (valve.clearance_volume + valve.piston_area * part for part in (valve.stroke - lift, lift))
    mass = sum(p * v / (r * t) for p, t, v in zip(states[:2], states[2:], volumes, strict=True))
    out = run.control_air - (mass[1] - mass[0])
    share = 2.0 * out / run.control_air
    return Claim(
        "sign_of_outflow",
        "Eq. 4",
        "The mass of a chamber changes by the inflow plus the outflow.",
        "dm = dm_in + dm_out",
        f"with Eq. 7's positive flows it is the difference, and mass closes to {run.closure['mass']:.0e}; by their sum "
        f"an opening and a closing would leave {share:.2f} times the control air too much in the chambers",
        {"mass_closure": run.closure["mass"], "mass_too_much_by_the_sum": share},
        verdict_of(abs(share) < 0.01),
        "Right only where dm_out is taken to be negative, which the paper does not say.",
    )
