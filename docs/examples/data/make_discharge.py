"""Discharge tests of a made-up solenoid valve: a vessel of 100 cm3 empties through it, the pressure is recorded.

From a checkout: ``python docs/examples/data/make_discharge.py``. The balances of mass and energy are written out here,
without apesim, so the effective area behind the files is known independently. ``true_curve.csv`` holds it.
"""

from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

FOLDER = Path(__file__).parent / "discharge"
R, K = 287.05, 1.4  # gas constant [J/(kg K)], heat capacity ratio of air
AMBIENT, ROOM = 101325.0, 293.15  # pressure [Pa abs], temperature [K]
VOLUME = 100e-6  # of the vessel [m3]
NOISE = 1.5e3  # standard deviation of the sensor of pressure [Pa]
TIMES = np.arange(-5e-3, 40e-3, 0.05e-3)  # after the switch [s]
GAUGE = (0.4e6, 0.6e6, 0.8e6)  # initial pressures [Pa gauge]
FULL_AREA = 7.2e-6  # effective area of the open valve [m2]


def opening(time):
    """Share of the full area: slow at first, then fast, then slow again, from 2.2 ms to 5.4 ms after the switch."""
    x = np.clip((time - 2.2e-3) / 3.2e-3, 0.0, 1.0)
    return x**2 * (3.0 - 2.0 * x)


def flow(area, pressure, temperature):
    """Mass flow from the vessel to ambient [kg/s], choked or not (Eqs. 7 and 8 of doi 10.1631/jzus.A0820373)."""
    ratio = max(AMBIENT / pressure, (2.0 / (K + 1.0)) ** (K / (K - 1.0)))
    psi = np.sqrt(2.0 * K / (K - 1.0) * max(ratio ** (2.0 / K) - ratio ** ((K + 1.0) / K), 0.0))
    return area * psi * pressure / np.sqrt(R * temperature)


def slopes(time, state):
    """Change of mass [kg/s] and internal energy [W] of the air in the vessel, without heat from its wall."""
    mass, energy = state
    temperature = energy * (K - 1.0) / (mass * R)
    out = flow(FULL_AREA * opening(time), mass * R * temperature / VOLUME, temperature)
    return -out, -out * K / (K - 1.0) * R * temperature


def main():
    """Write a file for each initial pressure, and the true curve."""
    rng, after = np.random.default_rng(2013), TIMES > 0.0
    FOLDER.mkdir(exist_ok=True)
    for gauge in GAUGE:
        start = ((AMBIENT + gauge) * VOLUME / (R * ROOM), (AMBIENT + gauge) * VOLUME / (K - 1.0))
        exact = {"t_eval": TIMES[after], "max_step": 1e-4, "rtol": 1e-9, "atol": 1e-12}
        energy = solve_ivp(slopes, (0.0, TIMES[-1]), start, **exact).y[1]
        pressure = np.append(np.full(np.sum(~after), AMBIENT + gauge), energy * (K - 1.0) / VOLUME)
        measured = pressure - AMBIENT + NOISE * rng.standard_normal(len(TIMES))
        rows = np.column_stack((1e3 * TIMES, measured / 1e3))
        path = FOLDER / f"p{gauge / 1e4:03.0f}.csv"
        np.savetxt(path, rows, ("%.2f", "%.2f"), ",", header="time [ms],pressure [kPa gauge]", comments="")
    times = np.linspace(0.0, 10e-3, 101)
    rows = np.column_stack((1e3 * times, 1e6 * FULL_AREA * opening(times)))
    header = "time [ms],effective_area [mm^2]"
    np.savetxt(FOLDER / "true_curve.csv", rows, ("%.1f", "%.4f"), ",", header=header, comments="")


if __name__ == "__main__":
    main()
