"""
Sweep over speed and supply pressure
====================================

How much torque does a higher supply pressure give, and up to which speed? A sweep computes all combinations of speed
and pressure and writes them into one archive. The archive is read as an xarray dataset with named axes.
"""

# %%
# ``vary`` takes any key of the machine file, with a range and its unit. ``overwrite=True`` lets the script run twice.

from pathlib import Path

import matplotlib.pyplot as plt

import apesim

Path("out").mkdir(exist_ok=True)
machine = apesim.Machine()
sweep = apesim.sweep(
    machine,
    speed="300:1500:200 rpm",
    intake="epv",
    timing="corrected",
    vary={"supply.pressure": "0.6:1.4:0.4 MPa gauge"},
    out="out/sweep_over_pressure.h5",
    overwrite=True,
)
print(sweep)

# %%
# The points without a good result, if there are any, and what the runs warn of:

print("\n".join(sweep.failed) or "every point has a result")
print("\n".join(sweep.warnings))

# %%
# The dataset has an axis for each quantity that was varied. Axes are in SI units: the pressure is absolute.

torque = sweep.dataset["brake_torque"].sel(actuation="epv corrected")
print(torque)

# %%
# Torque over speed, one line for each pressure.

gauge = (torque["supply_pressure"] - machine.ambient.pressure) / 1e6
torque = torque.assign_coords(supply_pressure=gauge.round(3))
figure, ax = plt.subplots(figsize=(5.8, 3.8), layout="constrained")
for pressure in torque["supply_pressure"].values:
    of_pressure = torque.sel(supply_pressure=pressure)
    ax.plot(torque["speed_rpm"], of_pressure, marker="o", ms=4, label=f"{pressure:g} MPa gauge")
ax.axhline(0, color="0.5", lw=0.8)
ax.set(xlabel="speed [r/min]", ylabel="brake torque [N m]")
ax.legend(title="supply pressure")

# %%
# The same numbers as a table, a row for each speed:

print(torque.to_pandas().T.round(2))

# %%
# Torque rises with the pressure at every speed, and falls with the speed at every pressure. The valve is switched at
# corrected command angles, so it opens and closes at its targets where it can. The figure does not show what the
# torque costs: ``sweep.dataset["specific_air_kg_per_kWh"]`` has the air for each point.
