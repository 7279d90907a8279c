"""
Closing the loop around the valve, step by step
===============================================

A controller of your own holds the opening and closing of the valve at their targets for a hundred turns, while the
speed and the supply change. It works on an engine that is marched in steps, as a test bench or another simulator
would drive it.
"""

# %%
# The engine turns at an imposed speed. A step ends at the next tooth of a wheel with 36 teeth: what is given to
# ``advance`` holds over the step, and what ``state`` and ``readings`` tell is that of its end. Numbers are bare and
# in SI here.

import matplotlib.pyplot as plt
import numpy as np

import apesim

TEETH, TURNS, TARGET = 36, 100, np.array([-5.0, 70.0])
rpm = 2.0 * np.pi / 60.0
stepper = apesim.Stepper(apesim.Machine(), "engine", speed="600 rpm")

# %%
# What the valve does late is nearly a time, not an angle. So the controller keeps a lead time for each edge [s],
# gathers the errors of the last stroke in it, and commands that much before the target, at the speed of the moment.


class Timing:
    """Integral law for the lead times of a valve."""

    def __init__(self, gain):
        self.gain, self.leads = gain, np.zeros(2)

    def learn(self, readings):
        """Take in when the valve opened and closed in the last revolution."""
        errors = np.array([readings.valve_open_deg[0], readings.valve_close_deg[0]]) - TARGET
        if not np.isnan(errors).any():
            self.leads += self.gain * np.radians(errors) / (readings.mean_speed_rpm * rpm)

    def command(self, speed):
        """Angles at which to energise and to release at a speed [rad/s]."""
        return apesim.EngineCommands(*map(float, TARGET - np.degrees(self.leads * speed)))


def course(turn):
    """Speed [rad/s] and pressure of the supply [Pa abs] in a turn: steps and a ramp."""
    speed = np.interp(turn, [30, 60], [600.0, 1000.0]) * rpm
    return speed, 0.8e6 if turn >= 80 else 1.1e6


# %%
# The loop. Each cylinder reads its command half a turn after its dead centre, so the command of the moment can be
# handed on at every step.

timing, turns, lifts, last = Timing(gain=0.25), [], [], -1
for step in range(TURNS * TEETH):
    speed, supply = course(step // TEETH)
    stepper.advance(stepper.time + 2.0 * np.pi / TEETH / speed, timing.command(speed), supply=supply, speed=speed)
    readings = stepper.readings
    if readings and readings.turns > last:
        last = readings.turns
        timing.learn(readings)
        turns.append(readings)
    if step >= (TURNS - 1) * TEETH:
        lifts.append(stepper.state()["lift_m"])

# %%
# How far the angles stray, and what the controller has found.

figure, axes = plt.subplots(3, sharex=True, figsize=(5.8, 6.4), layout="constrained")
number = [readings.turns for readings in turns]
for target, name, style in zip(TARGET, ("open", "close"), ("-", "--"), strict=True):
    angles = np.array([getattr(readings, f"valve_{name}_deg")[0] for readings in turns])
    axes[0].plot(number, angles - target, style, label=f"{name}s")
for key, style in (("energise", "-"), ("release", "--")):
    axes[1].plot(number, [getattr(readings, f"{key}_deg")[0] for readings in turns], style, label=key)
axes[2].plot(number, [readings.mean_speed_rpm for readings in turns])
axes[0].set(ylabel="error [deg]", ylim=(-8.0, 8.0))
axes[1].set(ylabel="command [deg]")
axes[2].set(ylabel="speed [r/min]", xlabel="turn [-]")
axes[2].axvspan(80, TURNS, color="0.93", lw=0)
axes[2].text(90, 0.08, "0.8 MPa", transform=axes[2].get_xaxis_transform(), ha="center")
axes[0].legend(loc="upper right", ncols=2)
axes[1].legend(loc="upper right", ncols=2)

# %%
# The numbers of the last ten turns of each part, and how well the air of all turns closes.

for first, part in ((20, "600 r/min"), (50, "the ramp"), (70, "1000 r/min"), (90, "0.8 MPa")):
    errors = np.array([(r.valve_open_deg[0], r.valve_close_deg[0]) for r in turns if first <= r.turns < first + 10])
    worst = np.abs(errors - TARGET).max(axis=0)
    print(f"{part}: opening off by {worst[0]:.2f} deg at most, closing by {worst[1]:.2f} deg")
print(f"highest lift at a tooth in the last turn: {1e3 * max(lifts):.2f} mm")
print("mass and energy close:", max(stepper.closure().values()) < 1e-9)

# %%
# The first strokes are late by tens of degrees, off the scale. Then the errors die out within some ten turns; what is
# read of a stroke acts on the one after the next, so that twice the gain would swing. Along the ramp the closing
# stays a little early, as a law that only gathers lags behind what changes. :doc:`/guide/stepping` has more on
# stepping.
