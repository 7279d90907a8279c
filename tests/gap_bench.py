"""Benches of the valve to be explained: one of the model's own with a side force of 3 N, others of the simulator in
tests/truth."""

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.measured import MeasuredRun
from apesim.studies.measured.prediction import predict, run_of
from apesim.valve.effects import VALVE_EFFECTS
from tests.truth.simulator.valve import POSITION, PRESSURE_A, PRESSURE_B, noise, simulate

AMBIENT = 101325.0
STROKE = 9e-3
NOISE = {"lift": 0.03e-3, "pressure_a": 2e3, "pressure_b": 2e3}
"""Standard deviations of what is recorded of a rig, SI."""
RIVALS = (
    *("moving_mass_error", "coulomb_friction", "stribeck_friction", "seal_friction", "quadratic_drag", "side_force"),
    *("spring_rate_error", "slow_ramp", "solenoid_a_delay", "leakage_a"),
)
"""Effects that come nearest to a force on the piston."""
BUT_RIVALS = tuple(effect.name for effect in VALVE_EFFECTS if effect.name not in RIVALS and not effect.tabulated)
"""All others but the tables: without them an explanation takes half as long."""


def write_bench(folder, force="3 N"):
    """Lift at three pressures, and at a fourth to check, with white noise of 0.02 mm."""
    machine = Machine.load(None, [f"effects.side_force.force={force}"])
    rng = np.random.default_rng(5)
    times = np.arange(-0.02, 0.07, 0.4e-3)
    lines = ['bench = "valve"']
    for pressure, role in ((0.16, "fit"), (0.40, "fit"), (0.60, "fit"), (0.49, "check")):
        run = MeasuredRun("", "", pressure * 1e6 + AMBIENT, 287.0, 0.03, role, times, {"lift": times})
        lift = predict(run_of(machine, run), run).channels["lift"] + 2e-5 * rng.standard_normal(len(times))
        name = f"p{100 * pressure:.0f}.csv"
        rows = (f"{1e3 * t:.6g},{1e3 * x:.6g}" for t, x in zip(times, lift, strict=True))
        (folder / name).write_text("\n".join(["time [ms],lift [mm]", *rows]) + "\n")
        lines += ["[[run]]", f'data = "{name}"', f'supply = "{pressure} MPa gauge"', 'temperature = "287 K"']
        lines += ['pulse = "30 ms"', f'role = "{role}"']
    (folder / "measured.toml").write_text("\n".join(lines) + "\n")
    return folder


def record(rig, rng, gauge, role, times, file=""):
    """Lift and both chambers of a pulse of 50 ms, by the independent simulator; gauge is what the record says."""
    states = simulate(rig, 50e-3, float(times[-1])).states(times)
    true = {"lift": STROKE - states[POSITION], "pressure_a": states[PRESSURE_A], "pressure_b": states[PRESSURE_B]}
    channels = {name: true[name] + noise(len(times), size, rng) for name, size in NOISE.items()}
    return MeasuredRun(f"{gauge:g}", file, gauge + AMBIENT, 287.0, 50e-3, role, times, channels)
