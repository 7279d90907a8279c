"""
Fitting a valve's parameters to laboratory data
===============================================

A valve was run on its bench: lift and the pressures of both chambers, at three supply pressures. Which friction,
solenoid area and dead time does it have? Two runs are fitted, with 95 % intervals. A third run is never fitted. It
judges the fitted model. The example ends with a question that the data cannot answer.

It reads files of the folder ``data``, which a download does not hold: copy ``docs/examples/data`` of the source code
beside the script.
"""

import matplotlib.pyplot as plt
import numpy as np

import apesim

# %%
# Reading the data
# ----------------
# A folder holds ``measured.toml`` and the CSV files that it names. ``measured.toml`` says how each run was made, and
# its role: ``fit``, ``gate`` or ``check``. Here the data come from an independent simulator, so the true values are
# known: 117 N·s/m, 8.8 mm² and 1.55 ms. The machine file says 111.08 N·s/m, 9 mm² and 1.5 ms.

measured = apesim.read_measured("data/laboratory")

figure, (above, below) = plt.subplots(2, 1, figsize=(6.4, 5.6), sharex=True, layout="constrained")
for run in measured.runs:
    time, gauge = 1e3 * run.times, (run.supply - measured.ambient_pressure) / 1e6
    above.plot(time, 1e3 * run.channels["lift"], ".", markersize=2, label=f"{gauge:.2f} MPa gauge, role {run.role}")
    print(f"{run.data}: {len(time)} samples of {', '.join(run.channels)}; supply {run.supply / 1e6:.3f} MPa abs")
for name in ("pressure_a", "pressure_b"):
    below.plot(time, run.channels[name] / 1e3, ".", markersize=2, label=f"{name}, {gauge:.2f} MPa gauge")
above.set(ylabel="lift [mm]", title="measured, 50 ms pulse, 287 K")
below.set(xlabel="time after the command [ms]", ylabel="pressure [kPa abs]")
above.legend(markerscale=4)
below.legend(markerscale=4, loc="center")

# %%
# Fitting
# -------
# First the viscous friction alone, then with the solenoids' area and dead time. A key of the machine file names each
# free parameter. Values are in SI units.

friction = ["valve.viscous_friction"]
solenoid = ["valve.solenoid.effective_area", "valve.solenoid.dead_time"]
true = {"valve.viscous_friction": 117.0, "valve.solenoid.effective_area": 8.8e-6, "valve.solenoid.dead_time": 1.55e-3}
fits = {"friction alone": apesim.fit(measured, friction), "all three": apesim.fit(measured, friction + solenoid)}

for name, fitted in fits.items():
    gate = fitted.gates[0]
    print(f"\n{name}: {'refused' if fitted.is_refused else 'accepted'} by {gate.run},")
    print(f"what is left there is {gate.residual_over_noise:.2f} of the noise, at most {gate.limit:.2f} is allowed")
    for key, scalar in fitted.scalars.items():
        low, high = fitted.interval_95[key]
        print(f"  {key:29} {scalar.value:10.5g} {scalar.unit:5}  95 %: {low:.5g} to {high:.5g}; true: {true[key]:.5g}")

# %%
# The run that judges
# -------------------
# Both fitted machines are run as the gate was, and the measured values are subtracted. In units of the sensor's noise,
# noise alone stays within ±2 for 95 % of the samples.

(run,) = measured.of("gate")
figure, axes = plt.subplots(3, 1, figsize=(6.4, 6.4), sharex=True, sharey=True, layout="constrained")
for name, fitted in fits.items():
    simulated = apesim.run_valve(
        fitted.fitted_machine, supply=run.supply, temperature=run.temperature, pulse=run.pulse, until=run.times[-1]
    )
    for axis, (sensor, values) in zip(axes, run.channels.items(), strict=True):
        expected = np.interp(run.times, simulated.traces["time"], simulated.traces[sensor])
        axis.plot(1e3 * run.times, (expected - values) / measured.noise[sensor], linewidth=0.9, label=name)
        axis.set_ylabel(f"{sensor}\n[sigmas of noise]")
for axis in axes:
    axis.axhspan(-2.0, 2.0, color="0.9", zorder=0, label="±2 standard deviations")
axes[0].set_title("model less measurement at 0.49 MPa gauge, never fitted")
figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
axes[-1].set_xlabel("time after the command [ms]")

# %%
# What cannot be identified
# -------------------------
# With the lift of one run alone, five parameters make up for one another. The fit says so. Its values are then no
# measurement of any single parameter.

first = measured.of("fit")[1]
lift_alone = measured._replace(runs=(first._replace(channels={"lift": first.channels["lift"]}),))
weak = apesim.fit(lift_alone, [*friction, *solenoid, "valve.spring_rate", "valve.moving_mass"])
for key, value in weak.parameters.items():
    low, high = weak.interval_95[key]
    print(f"{key:29} {value:10.5g}  95 %: {low:.5g} to {high:.5g}")
print(*weak.warnings, sep="\n")

plt.show()

# %%
# Fitted alone, the friction is wrong. It makes up for the solenoids, and the gate refuses the model. With all three
# parameters free, only noise is left, and the intervals hold the true values.
#
# The figure does not show that every other number of the machine is right. An error that acts like friction is found as
# friction. See :doc:`/gallery/missing_effect_found` for the search of what the model itself lacks, and
# :doc:`/guide/measured_data` for the format of the data.
