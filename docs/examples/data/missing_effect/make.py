"""Data like those of the paper's rig, from the independent simulator in ``tests/truth``, with an effect hidden in them.

From a checkout: ``PYTHONPATH=. python docs/examples/data/missing_effect/make.py``. The rig differs from the machine
file as rigs do: friction, effective area, dead time, supply and sensors are a little off, the same in all three sets.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.truth.simulator.valve import Bench, noise, simulate

HERE = Path(__file__).parent
AMBIENT = 101325.0
TIMES = np.arange(0.0, 0.1, 0.2e-3)
PULSE = 50e-3
RUNS = {0.16: "fit", 0.40: "fit", 0.49: "check"}
LIFT, PRESSURE = 0.03e-3, 2e3
RIG = Bench(viscous_friction=117.0, effective_area=8.8e-6, dead_time=1.55e-3, supply_temperature=288.0)


class Reading(NamedTuple):
    """What gauges say: true gauge pressure over the one that is read, and the lift's reading of a closed valve [m]."""

    gauge: float = 1.0
    lift_offset: float = 0.0


SETS = {
    "coulomb": (RIG._replace(dry_friction=6.0, breakaway=6.0), RUNS, True),
    "solenoid": (RIG._replace(delay_b=0.3e-3), RUNS, True),
    "coulomb_lift_alone": (RIG._replace(dry_friction=6.0, breakaway=6.0), {0.40: "fit"}, False),
}


def write_folder(folder: Path, rig: Bench, runs: Mapping[float, str], *, chambers: bool, reading: Reading, seed: int):
    """Write a folder of measured data: pulses at the pressures of ``runs`` [MPa gauge], each with its role."""
    rng = np.random.default_rng(seed)
    folder.mkdir(exist_ok=True)
    text = 'bench = "valve"\n[sensor.lift]\nnoise = "0.03 mm"\n'
    if chambers:
        text += '[sensor.pressure_a]\nnoise = "2 kPa"\n[sensor.pressure_b]\nnoise = "2 kPa"\n'
    for gauge, role in runs.items():
        here = rig._replace(supply_pressure=reading.gauge * gauge * 1e6 + AMBIENT)
        states = simulate(here, PULSE, float(TIMES[-1])).states(TIMES)
        lift = rig.stroke - states[0] + reading.lift_offset + noise(len(TIMES), LIFT, rng)
        header, columns = "time [ms],lift [mm]", [TIMES * 1e3, lift * 1e3]
        if chambers:
            header += ",pressure_a [kPa abs],pressure_b [kPa abs]"
            columns += [states[row] / 1e3 + noise(len(TIMES), PRESSURE / 1e3, rng) for row in (2, 4)]
        data = f"p{gauge * 100:03.0f}.csv"
        np.savetxt(folder / data, np.column_stack(columns), "%.5g", ",", header=header, comments="")
        text += f'\n[[run]]\ndata = "{data}"\nsupply = "{gauge:.2f} MPa gauge"\ntemperature = "287 K"\n'
        text += f'pulse = "50 ms"\nrole = "{role}"\n'
    (folder / "measured.toml").write_text(text)


def main():
    """Write a folder of measured data for each set."""
    for number, (name, (rig, runs, chambers)) in enumerate(SETS.items()):
        write_folder(HERE / name, rig, runs, chambers=chambers, reading=Reading(1.004, 0.01e-3), seed=1940 + number)


if __name__ == "__main__":
    main()
