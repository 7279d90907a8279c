"""
Can the valve reach 30 Hz?
==========================

The EPV paper (doi 10.1631/jzus.A0820373) says that its electro-pneumatic valve (EPV) reaches 30 Hz. How high is the
limit over the supply pressure, and which part of the work stops the valve? The valve is judged alone on its test
bench, and in the engine, where it also has to open and close at given crank angles.
"""

# %%
# On the bench, a rate counts if the piston of the valve meets both stops in every cycle. The limit depends on the
# duty, the share of the period for which the solenoids are energised. It is a half here. The result also holds the
# limit at the machine's own duty, that of its command angles.

import matplotlib.pyplot as plt
import numpy as np

import apesim

machine = apesim.Machine()
pressures = "0.6:1.4:0.4 MPa gauge"
bench = apesim.find_valve_limit(machine, pressure=pressures, temperature="287 K", duty=0.5)
print("on the bench:", bench.criterion)
print(bench)

# %%
# In the engine, the valve also has to open and close within 0.5° of its targets. Its window, from the target opening
# to the target closing, is 75° or 120° of crank angle. ``to_dict`` says what fails just above each limit.

engine = apesim.find_engine_limit(machine, pressure=pressures, temperature="287 K", duration="75 deg, 120 deg")
print("in the engine:", engine.to_dict()["criterion"])
for point in engine.to_dict()["points"]:
    gauge = (point["supply_pressure"] - machine.ambient.pressure) / 1e6
    print(f"{gauge:.1f} MPa gauge, {point['duration_deg']:.0f} deg: {point['limit_hz']:.1f} Hz, {point['fails']}")
print(f"{point['fails']}: {point['remedy']}")

# %%
# Both limits over pressure, and below them the time for which the valve is open at its limit, from lap to lap: the
# time for which its lift is above the lap, so that air flows.

figure, (top, bottom) = plt.subplots(2, sharex=True, figsize=(5.8, 6.4), layout="constrained")
limits = {
    "bench, duty 50 %": (bench, "duty", 0.5),
    "engine, window 120°": (engine, "duration_deg", 120),
    "engine, window 75°": (engine, "duration_deg", 75),
}
for label, (result, axis, value) in limits.items():
    chosen = np.isclose(result.traces[axis].values, value)
    gauge = (result.traces["supply_pressure"][chosen] - machine.ambient.pressure) / 1e6
    top.plot(gauge, result.traces["limit_hz"][chosen], marker="o", label=label)
    bottom.plot(gauge, 1e3 * result.traces["lap_to_lap"][chosen], marker="o", fillstyle="none")
top.axhline(30, color="k", ls="--", lw=1, label="30 Hz of the EPV paper")
top.set(ylabel="highest working rate [Hz]", ylim=(0, 110))
top.legend()
bottom.set(xlabel="supply pressure [MPa gauge]", ylabel="time from lap to lap [ms]", ylim=(0, None))

# %%
# One time decides nearly everything: the shortest time from lap to lap in which the valve opens fully. 30 Hz at one
# cycle per revolution are 1800 r/min, and need a window that is long enough for this time:

own = np.isclose(engine.traces["supply_pressure"].values, machine.supply.pressure)
time, window = engine.traces["rule_lap_to_lap"][own][0], engine.traces["rule_window_deg"][own][0]
print(f"1.0 MPa gauge: {1e3 * time:.2f} ms from lap to lap, so 30 Hz need a window of {window:.0f} deg")

# %%
# The valve passes 30 Hz on the bench, where it may stay open for about half of the period. With the short window of
# this engine it does not, because it has to turn back before it meets its open stop. Both windows of the engine need
# the same time from lap to lap: their lines lie on one another. The figure is for air of 287 K. Colder air lowers the
# limits.
