"""
First run
=========

What does the default engine do at 1000 r/min? One call simulates it until its state repeats from cycle to cycle. The
result holds numbers with their units, traces over the crank angle and an indicator diagram. It also shows how late
the electro-pneumatic valve (EPV) opens and closes.
"""

# %%
# The default machine is a single-cylinder engine of 0.5 L, supplied with air of 1.0 MPa gauge. ``run_engine`` returns
# one operating point. Its short text names the most important numbers.

import matplotlib.pyplot as plt
import numpy as np

import apesim

machine = apesim.Machine()
run = apesim.run_engine(machine, speed="1000 rpm")
print(run)

# %%
# Every number has a name, a unit and a meaning. ``run["brake_torque"]`` is the number alone.

for name in ["brake_torque", "specific_air_kg_per_kWh", "exergy_efficiency", "exhaust_temperature"]:
    scalar = run.scalars[name]
    print(f"{name:24} {scalar.value:10.4g} {scalar.unit:8} {scalar.long_name}")

# %%
# The solenoids are energised shortly before top dead centre (TDC) and released later, at the command angles. The
# valve follows late. It counts as open while its lift is above the lap, the lift from which on it lets air through.
# The fields of a machine are in SI units, so angles are in radians.

command_deg = np.rad2deg(machine.command.energise), np.rad2deg(machine.command.release)
true_deg = run["valve_open_deg"], run["valve_close_deg"]
for edge, wanted, found in zip(["opening", "closing"], command_deg, true_deg, strict=True):
    print(f"{edge}: command at {wanted:.1f} deg, valve follows at {found:.1f} deg, late by {found - wanted:.1f} deg")

# %%
# The traces over the crank angle: the lift, the pressure in the cylinder and the air flow through the intake.

angle_deg = run.traces["crank_angle_deg"]
figure, axes = plt.subplots(3, sharex=True, figsize=(5.8, 6.0), layout="constrained")
axes[0].plot(angle_deg, 1e3 * run.traces["lift"].values)
axes[0].axhline(1e3 * machine.groove.lap, color="0.5", ls=":", label="lap")
axes[0].set(ylabel="lift [mm]", ylim=(0, 11.5))
axes[1].plot(angle_deg, run.traces["cylinder_pressure"].values / 1e6)
axes[1].set(ylabel="cylinder pressure\n[MPa abs]")
axes[2].plot(angle_deg, 1e3 * run.traces["groove_flow"].values)
axes[2].set(xlabel="crank angle after TDC [deg]", ylabel="intake flow [g/s]")
for ax in axes:
    ax.axvspan(*command_deg, color="tab:orange", alpha=0.2, lw=0, label="solenoids energised")
    ax.axvspan(*true_deg, color="tab:blue", alpha=0.12, lw=0, label="valve open")
axes[0].legend(loc="upper right")

# %%
# The valve opens and closes long after its commands. The pressure in the cylinder falls while the engine's piston
# moves down and the valve is still closed. Then air enters until late in the stroke. The flanks of the lift show how
# long the valve needs from stop to stop.
#
# The indicator diagram shows the same cycle over the volume of the cylinder.

run.plot_indicator_diagram(plt.subplots(figsize=(5.8, 3.6), layout="constrained")[1])
print(f"indicated torque {run.scalars['indicated_torque']}, brake torque {run.scalars['brake_torque']}")

# %%
# The area of the diagram is the indicated work of a cycle. The brake torque is smaller by the friction of the engine,
# which the diagram does not show. Nor does it show the air that the valve needs to move itself.
