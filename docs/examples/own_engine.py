"""
An engine of one's own
======================

Who builds an air engine knows its bore and stroke, the size of its valve and the data sheet of its solenoid valves. The
moving mass or the dead volume of a chamber is hardly known. ``apesim.design_machine`` (``apesim new`` on the command
line) takes the former and derives the latter by stated rules. Here it makes a toy engine, and three machines of other
people's papers.

It reads files of the folder ``data``, which a download does not hold: copy ``docs/examples/data`` of the source code
beside the script.
"""

# %%
# A toy engine
# ------------
# A bore of 20 mm, for 3000 r/min. All that is not answered follows: ports from swept volume and speed, the valve from
# its groove, the solenoid valve from the time that the valve has. Each number says where it comes from.

from pathlib import Path

import matplotlib.pyplot as plt

import apesim

out = Path("out")
out.mkdir(exist_ok=True)
toy = apesim.design_machine(bore="20 mm", stroke="20 mm", rated_speed="3000 rpm", supply_pressure="0.6 MPa gauge")
for key in ("engine.bore", "groove.effective_area", "valve.moving_mass"):
    print(key, toy.to_dict()["keys"][key])
toy.write(out / "toy.toml", overwrite=True)

# %%
# The machine to scale, lengths in millimetres, and its indicator diagram at the rated speed:

fixed = apesim.run_engine(toy.machine, speed="3000 rpm")
_, (left, right) = plt.subplots(1, 2, figsize=(10.5, 6.4), width_ratios=(1.4, 1.0), layout="constrained")
toy.plot(left)
fixed.plot(right, "indicator diagram").set_title("3000 r/min, fixed command")

# %%
# It runs like any other machine. Its valve is late by the solenoid's dead time, which does not shrink with the engine:
# at 3000 r/min the 1.5 ms of the default solenoid valve are 27 degrees. Until it opens, the air in the clearance
# expands below ambient pressure, as the diagram shows. So the command angles have to be corrected.

print(f"fixed command: opens at {fixed['valve_open_deg']:.0f}°, {fixed['brake_torque']:.2f} N·m")
timing = apesim.correct_timing(
    toy.machine, target="-5 deg, 70 deg", speed="3000 rpm", pressure="0.6 MPa gauge", temperature="287 K"
)
[row] = timing.to_pandas().to_dict("records")
print(f"corrected: opens at {row['valve_open_deg']:.0f}°, {row['brake_torque']:.2f} N·m")

# %%
# What is implausible is said, with numbers and what to change. Here the valve is too small for its engine, and the
# solenoid valve too slow:

odd = apesim.design_machine(piston_diameter="6 mm", valve_stroke="3 mm", dead_time="40 ms")
print("\n".join(odd.warnings))

# %%
# Machines of papers
# ------------------
# Papers state few of the numbers that a simulation needs. ``data/papers`` has three machine files that were made in
# this way: what a paper states is an answer, what was assumed is named, and all else follows by rule. They do not
# repeat the papers: they show what a machine of that size gives, without a number that was tuned to them.

published = {"motorcycle": ("465 rpm", 9.99), "prototype_2_mpa": ("420 rpm", 56.0), "fast_solenoid": ("1000 rpm", None)}
for name, (speed, torque) in published.items():
    machine = apesim.Machine.load(f"data/papers/{name}.toml")
    run = apesim.run_engine(machine, speed=speed)
    told = "" if torque is None else f", {torque:g} N·m published"
    print(f"{name}: {run['brake_torque']:.1f} N·m at {speed}{told}")
plt.show()

# %%
# Such a comparison shows that the order of size is right, and no more: the published engines have other valves and
# other timing, which their papers do not tell. :doc:`/validation/huang` shows what single assumptions are worth.
