"""
A governor through load steps
=============================

A fan and, for three seconds, another load of 10 N·m pull at a free shaft. Two governors hold it at 900 r/min: one moves
the angle at which the valve closes, the other one the pressure of the supply. How far does the speed stray, and how
much air does each of them use for the work?
"""

# %%
# The fan takes 25 N·m at 900 r/min. With these commands the valve opens near -5° and closes near 70° at that speed, as
# ``apesim engine timing`` finds. The load steps up at 3 s, and down again at 6 s.

import matplotlib.pyplot as plt
import numpy as np

import apesim

machine = apesim.Machine().with_(
    shaft_inertia="0.1 kg m^2",
    load_quadratic="2.85e-3 N m s^2",
    **{"command.energise": "-41.2 deg", "command.release": "17.5 deg"},
)
target = 900.0
steps = {"from_speed": "900 rpm", "duration": "9 s", "load": "3 s: 10 N m, 6 s: 0 N m"}

# %%
# A controller is a function that is called once a revolution. It is told what sensors would tell, here the mean speed,
# and returns what it commands. The law of this one is the usual one: a part that follows the error of the speed, and
# one that gathers it, within limits.


class Governor:
    """Proportional and integral law for one command of the engine, which keeps what it was told."""

    def __init__(self, command, start, low, high, proportional, integral):
        self.command, self.gathered, self.low, self.high = command, start, low, high
        self.proportional, self.integral = proportional, integral
        self.seen = []

    def __call__(self, readings):
        self.seen.append(readings)
        error = target - readings.mean_speed_rpm
        self.gathered = np.clip(self.gathered + self.integral * error, self.low, self.high)
        value = np.clip(self.gathered + self.proportional * error, self.low, self.high)
        return apesim.EngineCommands(**{self.command: float(value)})


timing = Governor("release_deg", start=17.5, low=-20.0, high=120.0, proportional=0.07, integral=0.02)
pressure = Governor("supply_pressure_Pa", start=1.1e6, low=0.3e6, high=2.0e6, proportional=4e3, integral=1e3)

# %%
# Both governors, and for comparison the engine without any. A controller that returns None changes nothing: this one
# only keeps what it is told.

alone = []
runs = {
    "by closing angle": (apesim.run_transient(machine, controller=timing, **steps), timing.seen, "-"),
    "by pressure": (apesim.run_transient(machine, controller=pressure, **steps), pressure.seen, "--"),
    "no governor": (apesim.run_transient(machine, controller=alone.append, **steps), alone, ":"),
}

figure, axes = plt.subplots(4, sharex=True, figsize=(5.8, 8.2), layout="constrained")
for name, (_, seen, style) in runs.items():
    time = [readings.time_s for readings in seen]
    air = [readings.engine_air_kg + readings.control_air_kg for readings in seen]
    curves = [
        [readings.mean_speed_rpm for readings in seen],
        [readings.valve_close_deg[0] for readings in seen],
        [(readings.supply_pressure_Pa - machine.ambient.pressure) / 1e6 for readings in seen],
        [1e3 * each * readings.mean_speed_rpm / 60.0 for each, readings in zip(air, seen, strict=True)],
    ]
    for ax, curve in zip(axes, curves, strict=True):
        ax.plot(time, curve, style, label=name)
labels = "mean speed [r/min]", "closing angle [deg]", "supply [MPa gauge]", "air flow [g/s]"
for ax, label in zip(axes, labels, strict=True):
    ax.set_ylabel(label)
    ax.axvspan(3.0, 6.0, color="0.93", lw=0)
axes[0].text(4.5, 0.97, "load + 10 N m", transform=axes[0].get_xaxis_transform(), ha="center", va="top")
axes[-1].set_xlabel("time [s]")
figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)

# %%
# How far the speed strays, and what the work of the load costs in air once the speed has settled: in the last second
# before the steps, before the step down, and of the run.

for name, (run, _, _) in runs.items():
    rows = run.to_dict()["revolutions"]
    keys = "start_s", "mean_speed_rpm", "load_torque_Nm"
    start, speed, torque = (np.array([row[key] for row in rows]) for key in keys)
    air = np.array([row["engine_air_kg"] + row["control_air_kg"] for row in rows])
    work = 2.0 * np.pi * torque / 3.6e6  # kWh in a revolution
    print(f"{name}: lowest speed {speed[start > 2.0].min():.0f} r/min, highest {speed[start > 2.0].max():.0f} r/min")
    for second in (2.0, 5.0, 8.0):
        settled = (start >= second) & (start < second + 0.9)
        print(
            f"  from {second:g} s: {speed[settled].mean():.1f} r/min, {torque[settled].mean():.1f} N m, "
            f"{air[settled].sum() / work[settled].sum():.1f} kg/kWh"
        )
    print(f"  over all: {air.sum() / work.sum():.2f} kg/kWh")

# %%
# Both governors hold the speed. The one that moves the closing angle strays nearly twice as far: what it reads of a
# stroke acts on the one after the next, and a gain that is higher makes it swing, while the pressure acts at once. At
# the lower load it uses less air for the same work, as a lower pressure drives the engine with a long admission. At the
# higher load it is the other way round: it has to admit for longer, where the higher pressure expands further. The
# regulator of this supply follows at once and without loss; a real one is slower. The engine without a governor turns
# at other speeds, so its air is for other work.
