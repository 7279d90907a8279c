"""
Soft landing
============

How can the valve land more slowly on its stops? A brake switches one solenoid back for a short time while the piston
moves. A search finds the brakes for a given cost: the time by which the stroke may take longer.
"""

# %%
# The cost is at most 1 ms. The edges of a solenoid are at least 4.17 ms apart, which is a solenoid valve of 120 Hz.
# Only the solenoid that drives a stroke is switched back: B in an opening.

import matplotlib.pyplot as plt

import apesim

machine = apesim.Machine()
landing = apesim.find_soft_landing(machine, pressure="1.0 MPa gauge", cost="1 ms", spacing="4.17 ms", solenoids="b")
print(landing)

# %%
# The softest brake of the opening, and what is left of its effect where the pressure of the air strays by 5 % and its
# temperature by 10 K:

opening = landing.to_dict()["points"][0]
softest = opening["within_spacing"]["softest"]
free, begin, end = opening["unbraked"]["seating_speed_m_s"], *softest["edges_ms"][1:]
print(f"solenoid {softest['solenoids']} is switched back from {begin:.2f} to {end:.2f} ms after the command")
print(f"seating speed {softest['seating_speed_m_s']:.2f} m/s instead of {free:.2f} m/s")
print(f"time to contact longer by {softest['added_ms']:.2f} ms")
worst = max(softest["robustness"], key=lambda point: point["seating_speed_m_s"])
print(f"highest seating speed where the air strays: {worst['seating_speed_m_s']:.2f} m/s")

# %%
# Lift and velocity of the opening, with and without the brake.

time = 1e3 * landing.traces["time"].values
figure, (top, bottom) = plt.subplots(2, sharex=True, figsize=(5.8, 5.6), layout="constrained")
for name in ("unbraked", "braked"):
    top.plot(time, 1e3 * landing.traces[f"{name}_lift"][0], label=name)
    bottom.plot(time, landing.traces[f"{name}_velocity"][0])
for ax in (top, bottom):
    ax.axvspan(begin, end, color="0.88", lw=0, label="solenoid switched back")
top.set(ylabel="lift [mm]", xlim=(0, 20))
top.legend()
bottom.set(xlabel="time after the command [ms]", ylabel="velocity of the lift [m/s]", ylim=(-0.1, None))

contact = opening["unbraked"]["contact_ms"] + softest["added_ms"]
leaves = 1e6 * (machine.valve.stroke - landing.traces["braked_lift"][0][(time > contact) & (time < 20)].min())
print(f"after its contact the braked piston leaves the stop once more, by {leaves:.1f} µm")

# %%
# Both lifts are alike until shortly before the stop. There the braked piston slows down and meets the stop at a small
# part of the unbraked speed. The velocity falls to zero at the stop, as the stops are inelastic. The brake acts later
# than it is switched, as the solenoid valve has a dead time and the chamber has to empty. The figure is for one
# pressure. A brake that is made for it lands harder at another one.
