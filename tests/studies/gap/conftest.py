"""Folders of measured data as from a rig with a valve of the independent simulator."""

from itertools import count

import numpy as np
import pytest

from tests.truth.simulator.valve import noise, simulate

AMBIENT = 101325.0
TEMPERATURE = 287.0
TIMES = np.linspace(0.0, 0.1, 501)
PRESSURES = {0.16e6: "fit", 0.40e6: "fit", 0.70e6: "fit", 0.55e6: "gate", 0.49e6: "check"}
LIFT, PRESSURE = 0.03e-3, 2e3
SEED = 5000


@pytest.fixture
def measure(tmp_path):
    """Writes a folder as from a rig with a valve of the independent simulator.

    ``spoilt`` changes the columns of the second file, and returns what is noted of its gauge pressure if that is wrong.
    """
    numbers = count()

    def folder(bench, pressures=PRESSURES, chambers=True, gauge_error=0.0, late=0.0, seed=SEED, spoilt=None):
        path = tmp_path / f"data{next(numbers)}"
        path.mkdir()
        rng = np.random.default_rng(seed)
        text = 'bench = "valve"\n[sensor.lift]\nnoise = "0.03 mm"\n'
        for number, (gauge, role) in enumerate(pressures.items()):
            supply = gauge * (1.0 + gauge_error) + AMBIENT
            rig = bench._replace(supply_pressure=supply, supply_temperature=TEMPERATURE)
            states = simulate(rig, 50e-3, float(TIMES[-1])).states(TIMES)
            columns = {"time [s]": TIMES + late, "lift [m]": rig.stroke - states[0] + noise(len(TIMES), LIFT, rng)}
            if chambers:
                columns["pressure_a [Pa abs]"] = states[2] + noise(len(TIMES), PRESSURE, rng)
                columns["pressure_b [Pa abs]"] = states[4] + noise(len(TIMES), PRESSURE, rng)
            if number == 1 and spoilt:
                gauge = spoilt(columns) or gauge
            rows = "".join(",".join(map(repr, map(float, row))) + "\n" for row in zip(*columns.values(), strict=True))
            (path / f"{number}.csv").write_text(",".join(columns) + "\n" + rows)
            text += f'[[run]]\ndata = "{number}.csv"\nsupply = "{gauge / 1e6!r} MPa gauge"\ntemperature = "287 K"\n'
            text += f'pulse = "50 ms"\nrole = "{role}"\n'
        (path / "measured.toml").write_text(text)
        return path

    return folder
