"""
Own valve from discharge tests
==============================

How does the electro-pneumatic valve move with solenoid valves of your own? A discharge test gives the effective area
of a solenoid valve over time: a vessel empties through it, and the pressure is recorded. Here the curve is found from
three such tests, compared with the true one, and used in the machine.

It reads files of the folder ``data``, which a download does not hold: copy ``docs/examples/data`` of the source code
beside the script.
"""

# %%
# The tests are made up by ``data/make_discharge.py``: a vessel of 100 cm³ at three initial pressures, with noise. The
# script computes the pressures without apesim, so the true curve is known. A test is a CSV file with time and
# pressure. Time 0 is the switch of the solenoid valve, and the unit says whether the pressure is ``gauge`` or
# ``abs``.

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import apesim

Path("out").mkdir(exist_ok=True)
machine = apesim.Machine()
area = apesim.evaluate_discharge(
    machine,
    [f"data/discharge/p{pressure}.csv" for pressure in ("040", "060", "080")],
    volume="100 cm^3",
    out="out/opening_curve.csv",
    overwrite=True,
)
print(area)
print("\n".join(area.warnings) or "no warnings")

# %%
# The measured pressures of all tests, and the effective area that explains them together, with its 95 % band. The
# dashed line is the truth, which is known for tests that are made up only.

figure, (left, right) = plt.subplots(1, 2, figsize=(5.8, 3.2), layout="constrained")
for test in area.evaluation.records:
    left.plot(1e3 * test.times, test.pressures / 1e6, lw=1, label=test.name)
left.set(xlabel="time after the switch [ms]", ylabel="pressure [MPa abs]", xlim=(-2, 30))
left.legend()
area.plot(right).lines[-1].set_label("found, and\n95 % band")
found, half_band = area["effective_area_mm2"], area["effective_area_half_band_mm2"]
print(f"open valve: {found:.2f} mm² ± {half_band:.2f} mm² found")

# With tests of your own, the true curve is not known: leave out the lines from here down to the legend.
true_time, true_area = np.loadtxt("data/discharge/true_curve.csv", delimiter=",", skiprows=1, unpack=True)
right.plot(true_time, true_area, "k--", lw=1, label="truth")
at_knots = np.interp(1e3 * area.traces["time"].values, true_time, true_area)
within = (at_knots >= 1e6 * area.traces["low"].values) & (at_knots <= 1e6 * area.traces["high"].values)
print(f"the truth is within the band at {within.mean():.0%} of the points of the curve")
print(f"open valve: {true_area[-1]:.2f} mm² true")

right.legend()

# %%
# The curve and the full area go into the machine. The curve replaces dead time and ramp of the default valve.

own = machine.with_(valve_solenoid_effective_area=f"{found} mm^2", valve_solenoid_opening_curve="out/opening_curve.csv")
figure, ax = plt.subplots(figsize=(5.8, 3.6), layout="constrained")
for label, valve in {"default solenoid valves": machine, "own solenoid valves": own}.items():
    run = apesim.run_valve(valve, supply="0.6 MPa gauge", pulse="25 ms")
    run.plot(ax).lines[-1].set_label(label)
    print(f"{label}: delay time {1e3 * run['opening_delay']:.2f} ms, ", end="")
    print(f"full stroke time {1e3 * run['opening_stroke_time']:.2f} ms at the opening")
ax.legend()

# %%
# The curve that was found follows the true one. Solenoid valves that are smaller and slower make the piston start
# later and move more slowly. The bench run does not show what that costs in the engine: ``apesim.run_engine(own,
# speed="1000 rpm")`` does.
