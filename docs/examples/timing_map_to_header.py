"""
Timing map to a C header
========================

When does a controller have to switch the solenoids, so that the valve really opens and closes at its targets? The
answer is a map of command angles over speed and supply pressure. It is written as a C header for the controller. Then
it is read back, and its interpolation is checked between the points of the map.
"""

# %%
# ``correct_timing`` solves the command angles at each point. ``write`` writes an archive, and beside it the map as
# CSV, JSON and C header.

import re
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import RegularGridInterpolator

import apesim

Path("out").mkdir(exist_ok=True)
machine = apesim.Machine()
timing = apesim.correct_timing(
    machine, target="-5 deg, 70 deg", speed="400:1000:150 rpm", pressure="0.6:1.4:0.4 MPa gauge", temperature="287 K"
)
timing.write("out/timing_map.h5", overwrite=True)
print(timing)

# %%
# The header says its targets, axes, units and its largest error of interpolation. A function in it interpolates. It
# returns 1; or 2 near points at which the valve meets its targets but turns back before its open stop, as it does at
# higher speeds than these; or 0 where there are no commands.

header = Path("out/timing_map.h").read_text()
print(header[: header.index("#ifndef")])

# %%
# The arrays are read back from the text of the header. The advance is the target angle less the command angle.


def read_array(name):
    """Numbers of an array in the header."""
    initialiser = re.search(rf"\b{name}\[.*?= {{(.*?)}};", header, re.DOTALL)[1]
    return np.array(re.findall(r"-?\d[\d.e+-]*", initialiser), float)


speed, pressure = read_array("apesim_speed"), read_array("apesim_pressure")
maps = {}
for name in ("advance", "release_advance"):
    values = read_array(f"apesim_{name}").reshape(len(speed), len(pressure))
    maps[name] = RegularGridInterpolator((speed, pressure), values)
print(
    f"speed {speed[0]:g} to {speed[-1]:g} r/min, pressure {pressure[0] / 1e6:.3f} to {pressure[-1] / 1e6:.3f} MPa abs"
)

# %%
# Other points, between those of the map, are solved for comparison.

between = apesim.correct_timing(
    machine, speed="440 rpm, 650 rpm, 960 rpm", pressure="0.75 MPa gauge, 1.2 MPa gauge", temperature="287 K"
)
points = np.column_stack((between.traces["speed_rpm"], between.traces["supply_pressure"]))
figure, axes = plt.subplots(2, sharex=True, figsize=(5.8, 5.6), layout="constrained")
fine = np.linspace(speed[0], speed[-1], 100)
colours = plt.cm.viridis(np.linspace(0, 0.85, 2))
for ax, (name, interpolate) in zip(axes, maps.items(), strict=True):
    solved = between.traces[f"{name}_deg"].values
    error = interpolate(points) - solved
    print(f"{name}: error between the points at most {np.abs(error).max():.3f} deg")
    for at, colour in zip(np.unique(points[:, 1]), colours, strict=True):
        here = points[:, 1] == at
        label = f"{(at - machine.ambient.pressure) / 1e6:g} MPa gauge"
        ax.plot(fine, interpolate((fine, at)), color=colour, label=f"map, {label}")
        ax.plot(points[here, 0], solved[here], "x", color=colour, label=f"solved, {label}")
axes[0].set(ylabel="energise earlier by [deg]")
axes[1].set(xlabel="speed [r/min]", ylabel="release earlier by [deg]")
axes[0].legend()

# %%
# The lines are the map, interpolated between its points. The crosses are solved on the coupled model. The commands
# come earlier as the speed rises, as the valve needs about the same time at each speed. The error is that of the
# interpolation alone. The figure does not show how far the model itself is from a real valve.
