"""An example to try the search on: a valve's bench whose piston is pushed to open, which its machine file does not say.

The examples of this package read it. Its data are made by the machine itself, so that they show how a search runs, and
nothing of how well it would do on a real bench.
"""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.gap.explanation import Explanation
from apesim.studies.gap.search.calibrated_gap import CalibratedGap, check_against_noise
from apesim.studies.gap.search.file_numbers import SUSPECTS
from apesim.studies.gap.search.library import select_effects
from apesim.studies.gap.workflow import explain
from apesim.studies.measured import CHECK, FIT, GATE, VALVE, Measured, MeasuredRun, read_measured
from apesim.studies.measured.prediction import predict, run_of, with_value

SIDE_FORCE = 3.0
"""Force on the piston that the machine lacks [N]."""
ROLES = {0.3: FIT, 0.4: FIT, 0.5: GATE, 0.6: CHECK}
"""Roles of the runs, by the pressure of their supply [MPa gauge]."""
TIMES = np.arange(0.0, 0.08, 0.5e-3)
"""Times of the samples: a pulse of 40 ms, and as long again for the valve to close [s]."""
NOISE = 0.03e-3
"""Standard deviation of the lift's noise [m]: that of a usual laser sensor."""
SEED = 20
LIBRARY = ("coulomb_friction", "side_force", "spring_rate_error", "tabulated_force")
"""Effects that are considered: few, so that a search takes seconds."""


def write_example(folder: Path) -> None:
    """Write the measured data of the example, the lift at four supply pressures, into a folder that exists."""
    machine = Machine()
    pushed = with_value(machine, "effects.side_force.force", SIDE_FORCE)
    rng = np.random.default_rng(SEED)
    lines = ['bench = "valve"', "[sensor.lift]", f'noise = "{NOISE * 1e3:g} mm"']
    for gauge, role in ROLES.items():
        supply = gauge * 1e6 + machine.ambient.pressure
        run = MeasuredRun("", "", supply, 293.15, 0.04, role, TIMES, {"lift": np.zeros(len(TIMES))})
        lift = predict(run_of(pushed, run), run).channels["lift"] + NOISE * rng.standard_normal(len(TIMES))
        rows = (f"{1e3 * time:.6g},{1e3 * value:.6g}" for time, value in zip(TIMES, lift, strict=True))
        name = f"p{100 * gauge:.0f}.csv"
        (folder / name).write_text("\n".join(["time [ms],lift [mm]", *rows]) + "\n")
        lines += ["[[run]]", f'data = "{name}"', f'supply = "{gauge:g} MPa gauge"', 'temperature = "293.15 K"']
        lines += ['pulse = "40 ms"', f'role = "{role}"']
    (folder / "measured.toml").write_text("\n".join(lines) + "\n")


@cache
def read_example() -> Measured:
    """The measured data of the example, see `write_example`; made once."""
    with TemporaryDirectory() as folder:
        write_example(Path(folder))
        return read_measured(folder, Machine().ambient.pressure)


def list_left_out() -> list[str]:
    """What the example leaves out: all effects that are not in `LIBRARY`, and numbers that may be wrong."""
    effects = [effect.name for effect in select_effects("valve") if effect.name not in LIBRARY]
    return effects + [suspect.key for suspect in SUSPECTS[VALVE]]


@cache
def explain_example() -> Explanation:
    """The explanation of the example, by the effects of `LIBRARY` alone; found once."""
    with TemporaryDirectory() as folder:
        write_example(Path(folder))
        explanation = explain(Machine(), folder, without=list_left_out())
        explanation.to_dict()  # reads the data for their digests, while they are there
    return explanation


@cache
def find_example_gap() -> CalibratedGap:
    """The gap of the example, its machine calibrated; found once."""
    explanation = explain_example()
    return check_against_noise(explanation.calibrated, explanation.sensitivities, [])
