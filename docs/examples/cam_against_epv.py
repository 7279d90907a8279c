"""
Cam against electro-pneumatic valve
===================================

What does the lateness of the electro-pneumatic valve (EPV) cost, and how much of it do corrected commands win back?
Four intakes drive the same engine over speed: a cam, an ideal valve, and the EPV with fixed and with corrected
commands.
"""

# %%
# One call computes all four. ``timing="both"`` gives the EPV twice: with the command angles of the machine, and with
# commands so much earlier that it really opens and closes at those angles.

import matplotlib.pyplot as plt

import apesim

sweep = apesim.sweep(apesim.Machine(), speed="300:2100:200 rpm", intake=["cam", "ideal", "epv"], timing="both")
print(sweep)
print("\n".join(sweep.warnings))

# %%
# Specific air is all air, control air counted, over brake work. It is undefined where the engine does not give any
# work. The points of the EPV with fixed timing above 150 kg/kWh are not drawn.

figure, (top, bottom) = plt.subplots(2, sharex=True, figsize=(5.8, 6.0), layout="constrained")
names = {"ideal": "ideal valve", "cam": "cam", "epv corrected": "EPV, corrected", "epv": "EPV, fixed"}
for actuation, label in names.items():
    points = sweep.dataset.sel(actuation=actuation)
    top.plot(points["speed_rpm"], points["brake_torque"], marker="o", ms=4, label=label)
    bottom.plot(points["speed_rpm"], points["specific_air_kg_per_kWh"], marker="o", ms=4)
top.axhline(0, color="0.5", lw=0.8)
top.set(ylabel="brake torque [N m]")
top.legend()
bottom.set(xlabel="speed [r/min]", ylabel="specific air [kg/kWh]", ylim=(0, 150))

# %%
# Brake torque and specific air at two speeds, and whether the valve opens fully there:

table = sweep.dataset[["brake_torque", "specific_air_kg_per_kWh", "peak_lift"]].sel(speed_rpm=[900, 1500])
print(table.to_dataframe().round(4))

# %%
# At low speed the EPV with fixed timing closes late. So it gives more torque than any other, but takes more air for it.
# At high speed it opens so late that the torque is lost. With corrected commands, the torque is above that of the cam
# at low speed and below it at high speed, where the valve turns back before its open stop (``peak_lift`` in the
# table). A part of the difference at low speed is the cam's own: it begins to lift at the angle at which the other
# valves are open already, so it is open for some 64° and they for 75°. Corrected commands remove the lateness. They
# do not make the valve faster, and they do not save the air that moves it. The figure does not show these two parts
# alone: ``apesim.assess_valve`` does.
