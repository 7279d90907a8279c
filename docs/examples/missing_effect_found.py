"""
A missing effect: found, added and checked
==========================================

Simulation and measurement disagree. Is something missing in the model, and what? ``apesim.explain`` calibrates the
machine, tests whether more than noise is left, and searches its library of effects. Here it finds an effect that was
hidden in the data, and shows the gap before and after on a run that was never used. A second part shows data that
cannot answer.

It reads files of the folder ``data``, which a download does not hold: copy ``docs/examples/data`` of the source code
beside the script.
"""

from pathlib import Path

import matplotlib.pyplot as plt

import apesim

# %%
# The data are a valve's lift and chamber pressures, made by an independent simulator. One effect is hidden in them: a
# solenoid that is late by 0.3 ms. As on any rig, friction, areas, dead time and gauges are a little off, too. Two runs
# are fitted. The third, with the role ``check``, is opened once at the end.

machine = apesim.Machine()
explanation = apesim.explain(machine, "data/missing_effect/solenoid")
print(explanation)

# %%
# The verdict, what is missing, and its 95 % interval. The gap is the root mean square of what is left over the noise:
# 1 is noise alone.

print(explanation.verdict)
for effect in explanation.effects:
    low, high = effect["interval_95"]
    print(f"{effect['key']} = {effect['value']:.3f} {effect['unit']}, 95 %: {low:.3f} to {high:.3f} {effect['unit']}")
checked = explanation.held_out
print(f"gap on the run never used: {checked['before']:.2f} before, {checked['after']:.2f} after")

# %%
# What is left of two signals on that run, before and after the effect is added:

figure, axes = plt.subplots(2, 1, figsize=(6.4, 6.0), sharex=True, layout="constrained")
explanation.plot(axes[0])
explanation.plot(axes[1], sensor="lift")
axes[0].set_xlabel("")
axes[1].set_title("")
axes[1].get_legend().remove()

# %%
# The report, the figures and a machine file with the effect and with the calibrated numbers are written into a folder.
# The machine is used like any other: here for the torque that the late solenoid costs.

found = Path("out/solenoid")
explanation.write(found, overwrite=True)
late = apesim.Machine.load(found / "machine.toml")
on_time = late.with_(**{"effects.solenoid_b_delay.time": "0 ms"})
for name, each in {"as found": late, "without the delay": on_time}.items():
    run = apesim.run_engine(each, speed="1000 rpm")
    print(f"{name:17}: {run['brake_torque']:.2f} N m, the intake opens at {run['valve_open_deg']:.1f} deg")

# %%
# Data that cannot answer
# -----------------------
# The second set hides Coulomb friction of 6 N. Only the lift was measured, at one pressure. The viscous friction takes
# up what the Coulomb friction does, so nothing is named. The report says from which size on these data would have
# shown it.

unanswered = apesim.explain(machine, "data/missing_effect/coulomb_lift_alone")
print(unanswered.verdict, "-", unanswered.sentence)
limit = unanswered.detection_limits["coulomb_friction"]
print(f"Coulomb friction would have shown from {limit['limit']:.1f} {limit['unit']} on")

plt.show()

# %%
# The figure shows that the gap closes on a run that played no part in the search. It does not show that no other
# physics could close it: a name is always one of the library. ``NO_GAP`` means that these data show nothing, not that
# nothing is missing. :doc:`/missing_effect/index` describes the whole workflow.
