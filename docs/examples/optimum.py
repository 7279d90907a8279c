"""
Best commands at one speed
==========================

Which command angles give the most torque, and which the least air for the work? The two goals oppose each other. The
Pareto front joins them: along it, more torque always costs more air.
"""

# %%
# The search varies the angles of energising and of release. Each point is the coupled engine at its periodic state.

import matplotlib.pyplot as plt

import apesim

machine = apesim.Machine()
best = apesim.optimise_commands(machine, speed="1000 rpm", goal="both")
print(best)

# %%
# The machine's own commands, and both ends of the front:

names = {"fixed": "own commands", "least_air": "least specific air", "most_torque": "most torque"}
for kind, name in names.items():
    energise, release, torque, air = (
        best.traces[f"{kind}_{quantity}"][0]
        for quantity in ("energise_deg", "release_deg", "brake_torque", "specific_air_kg_per_kWh")
    )
    print(f"{name:18}: {energise:5.1f} to {release:5.1f} deg, {torque:.2f} N m, {air:.1f} kg/kWh")

# %%
# The front, and the angles at which the valve really opens and closes along it.

torque = best.traces["front_brake_torque"][0]
figure, (top, bottom) = plt.subplots(2, sharex=True, figsize=(5.8, 6.0), layout="constrained")
top.plot(torque, best.traces["front_specific_air_kg_per_kWh"][0], ".-", label="Pareto front")
for (kind, name), marker in zip(names.items(), "osD", strict=True):
    at = best.traces[f"{kind}_brake_torque"][0], best.traces[f"{kind}_specific_air_kg_per_kWh"][0]
    top.plot(*at, marker, color="k", fillstyle="none", label=name)
top.set(ylabel="specific air [kg/kWh]", ylim=(0, None))
top.legend(loc="lower right")
bottom.plot(torque, best.traces["front_valve_close_deg"][0], ".-", label="valve closes")
bottom.plot(torque, best.traces["front_valve_open_deg"][0], ".-", label="valve opens")
bottom.set(xlabel="brake torque [N m]", ylabel="crank angle after TDC [deg]")
bottom.legend(loc="center right")

# %%
# The machine's own commands are far from the front: other angles give more torque for less air. Along the front the
# valve opens at nearly the same angle, shortly before top dead centre (TDC), and closes ever later. A later closing
# admits more air, which expands less. The front holds for this speed and this supply pressure only.
