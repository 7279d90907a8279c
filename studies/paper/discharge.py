"""Discharge tests of the model's own solenoid (Fig. 3): the paper's measured ones survive as a figure only.

A vessel is emptied by mass and energy balance through the solenoid as it opens, without Eqs. 9 and 10, which are what
the tests are to show. Seeded noise is put on its pressure; what is made of the tests is made by
`apesim.studies.discharge`.
"""

import numpy as np

from apesim.air import GasState, gas_of, internal_energy, temperature_of
from apesim.engine.machine import Machine
from apesim.restriction import Sides, flow_between
from apesim.studies.discharge import Record, Vessel
from apesim.valve.solenoid import followed, opening_curve

GAUGE = (0.4e6, 0.6e6, 0.8e6)
"""The paper's initial pressures [Pa gauge]."""
LENGTH = 50.0 / 9.0
"""Volume of the vessel over the effective area [m], chosen: 50 cm3 for 9 mm2."""
NOISE = 0.5e3
"""Standard deviation, chosen: 0.05 % of a sensor of 1 MPa [Pa]."""
RATE = 50e3
"""Samples a second, chosen."""
BEFORE, AFTER = 5e-3, 12e-3
"""Times recorded before the switch, and after the valve is open [s]."""


def vessel_of(machine: Machine) -> Vessel:
    """The vessel of the tests, filled at the ambient temperature."""
    ambient = machine.ambient
    volume = LENGTH * machine.valve.solenoid.effective_area
    return Vessel(volume, ambient.temperature, ambient.pressure, gas_of(machine.air))


def area_at(machine: Machine, times: np.ndarray) -> np.ndarray:
    """Effective area of the model's solenoid [m2] at `times` (n,) after it is switched at 0 [s]."""
    solenoid = machine.valve.solenoid
    curve = opening_curve(solenoid)
    return solenoid.effective_area * np.array([followed(curve, t) for t in times])


def emptied(machine: Machine, vessel: Vessel, initial_pressure: float, times: np.ndarray) -> np.ndarray:
    """Pressure of a vessel that empties through the model's solenoid, by mass and energy balance [EPV, Eqs. 3 to 8].

    Pressures are in Pa abs, `times` (n,) after the switch in s, ascending.

    >>> machine = Machine()
    >>> vessel = vessel_of(machine)
    >>> pressures = emptied(machine, vessel, vessel.ambient_pressure + 0.4e6, np.array([0.0, 5e-3, 10e-3]))
    >>> (pressures / 1e6).round(2)
    array([0.5 , 0.44, 0.34])
    """
    from scipy.integrate import solve_ivp

    gas, solenoid = vessel.gas, machine.valve.solenoid
    curve, outside = opening_curve(solenoid), GasState(vessel.ambient_pressure, vessel.temperature)
    r_per_volume = gas.gas_constant / vessel.volume

    def rates(t: float, y: np.ndarray) -> tuple[float, float]:
        mass, energy = y
        temperature = temperature_of(gas, energy / mass)
        area = solenoid.effective_area * followed(curve, t)
        pressure = mass * temperature * r_per_volume
        out, carried = flow_between(gas, area, Sides(GasState(pressure, temperature), outside))
        return -out, -carried

    mass = initial_pressure / (r_per_volume * vessel.temperature)
    start = np.array([mass, mass * internal_energy(gas, vessel.temperature)])
    corners = np.unique(np.clip(np.append(0.0, curve[:, 0]), 0.0, times[-1]))
    parts = [np.full(int(np.sum(times <= 0.0)), initial_pressure)]
    for begin, end in zip(corners, [*corners[1:], times[-1]], strict=True):
        within = times[(times > begin) & (times <= end)]
        if end > begin:
            instants = np.unique(np.append(within, end))
            solution = solve_ivp(rates, (begin, end), start, t_eval=instants, rtol=1e-9, atol=1e-12)
            start = solution.y[:, -1]
            masses, energies = solution.y[:, : len(within)]
            t = np.array([temperature_of(gas, u) for u in energies / masses])
            parts.append(masses * t * r_per_volume)
    return np.concatenate(parts)


def discharge_tests(
    machine: Machine, noise: float = NOISE, rate: float = RATE, seed: int = 0
) -> tuple[Vessel, list[Record]]:
    """Make discharge tests of the model's solenoid from the paper's initial pressures.

    `noise` is the standard deviation of the noise on the pressure [Pa], `rate` the samples a second [1/s], `seed` the
    start of the random numbers.
    """
    vessel, random = vessel_of(machine), np.random.default_rng(seed)
    end = opening_curve(machine.valve.solenoid)[-1, 0] + AFTER
    times = np.arange(-round(BEFORE * rate), round(end * rate) + 1) / rate
    records = []
    for gauge in GAUGE:
        pressures = emptied(machine, vessel, vessel.ambient_pressure + gauge, times)
        noisy = pressures + noise * random.standard_normal(len(times))
        records.append(Record(f"{gauge / 1e6:g} MPa gauge", times, noisy))
    return vessel, records
