"""
Ideal gas against air whose heat capacity depends on temperature
================================================================

Air in an engine that expands it gets cold. An ideal gas has one heat capacity at all temperatures; that of air depends
on temperature. How much does this change torque, specific air consumption and temperature? A cam-driven intake is swept
over speed and supply pressure, once with each model of the air.
"""

import matplotlib.pyplot as plt

import apesim

# %%
# The key ``air.model`` chooses the model: ``"ideal"`` is the default, with a heat capacity ratio of 1.4;
# ``"thermally_perfect"`` takes cp(T) of air by Lemmon and others. A choice is swept like any other key of the machine.

machine = apesim.Machine()
swept = apesim.sweep(
    machine,
    "400:2000:400 rpm",
    intake="cam",
    vary={"air.model": "ideal, thermally_perfect", "supply.pressure": "0.6:1.4:0.4 MPa gauge"},
)
data = swept.dataset.squeeze("actuation")
ideal, real = data.sel(air_model="ideal"), data.sel(air_model="thermally_perfect")

# %%
# Change of the results when cp(T) replaces the constant heat capacity. Specific air consumption is the mass of all air
# over the brake work.

panels = {
    "brake torque, change [%]": 100 * (real["brake_torque"] / ideal["brake_torque"] - 1),
    "specific air, change [%]": 100 * (real["specific_air_kg_per_kWh"] / ideal["specific_air_kg_per_kWh"] - 1),
    "coldest cylinder air, change [K]": real["lowest_cylinder_temperature"] - ideal["lowest_cylinder_temperature"],
}
figure, axes = plt.subplots(3, 1, figsize=(6.4, 7.2), sharex=True, layout="constrained")
for axis, (label, change) in zip(axes, panels.items(), strict=True):
    for pressure in change["supply_pressure"].values:
        gauge = (pressure - machine.ambient.pressure) / 1e6
        axis.plot(change["speed_rpm"], change.sel(supply_pressure=pressure), "o-", label=f"{gauge:.1f} MPa gauge")
    axis.set_ylabel(label)
    axis.axhline(0.0, color="0.6", linewidth=0.8)
axes[0].legend(title="supply pressure")
axes[-1].set_xlabel("speed [r/min]")
axes[0].set_title("cp(T) of air instead of a constant cp")

torque, air, coldest = (change.values for change in panels.values())
print(f"brake torque:         {torque.min():+.2f} to {torque.max():+.2f} %")
print(f"specific air:         {air.min():+.2f} to {air.max():+.2f} %")
print(f"coldest cylinder air: {coldest.min():+.2f} to {coldest.max():+.2f} K")

# %%
# How cold the air is, and for how much of a turn it is colder than 300 K. No wall gives heat to the air here, so
# this is an adiabatic limit: real air does not become so cold.

temperature = real["cylinder_temperature"].sel(supply_pressure=machine.supply.pressure, method="nearest")
share = (temperature < 300.0).mean("crank_angle_deg")
figure, axis = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
for speed in (400.0, 2000.0):
    axis.plot(temperature["crank_angle_deg"], temperature.sel(speed_rpm=speed), label=f"{speed:.0f} r/min")
axis.set(
    xlabel="crank angle after TDC [deg]",
    ylabel="cylinder temperature [K]",
    title="1.0 MPa gauge, cp(T), adiabatic limit",
)
axis.legend()
for speed in (400.0, 2000.0):
    below = float(share.sel(speed_rpm=speed))
    print(f"{speed:4.0f} r/min: colder than 300 K during {below:.0%} of a turn")

plt.show()

# %%
# The model of the air hardly matters for torque and specific air consumption at these operating points. The ideal gas
# is good enough for them.
#
# The cp of air hardly changes in the cold: at 160 K it is 0.25 % below that at 300 K. It rises in the heat of the
# compression. Both models obey the ideal gas law, and in both the air is dry: no water condenses or freezes. The
# equations stand in :doc:`/theory/gas`.
