"""
An effect of one's own
======================

The library of effects can be extended by a Python file. This example adds a valve bore that narrows towards its open
end, so that the friction of the piston's rings grows on the way there. It shows what this does to the valve's lift on
its bench, and to the torque of the engine.

It reads files of the folder ``data``, which a download does not hold: copy ``docs/examples/data`` of the source code
beside the script.
"""

from pathlib import Path

import matplotlib.pyplot as plt

import apesim

# %%
# The file
# --------
# It holds the effect's parameters with unit, range and source, its law, and a description. The first parameter is the
# strength; at strength 0 the effect does nothing.

file = "data/tapered_bore.py"
print(Path(file).read_text(encoding="utf-8"))

# %%
# The machine
# -----------
# ``with_effects`` runs the file, so name only files that you know. From then on the effect has keys like any other. The
# first run with it compiles the law.

machine = apesim.Machine().with_effects(file)
entry = apesim.list_effects(machine)["tapered_bore"]
print(f"{entry.name}: {entry.equation}, from {entry.file}")

# %%
# Lift on the bench
# -----------------

key = "effects.tapered_bore.friction"
figure, (opening, closing) = plt.subplots(1, 2, figsize=(6.4, 3.8), sharey=True, layout="constrained")
for friction in ("0 N s/m", "60 N s/m", "120 N s/m"):
    run = apesim.run_valve(machine.with_(**{key: friction}), supply="0.49 MPa gauge")
    for axis in (opening, closing):
        axis.plot(1e3 * run.traces["time"].values, 1e3 * run.traces["lift"].values, label=friction)
    times = [1e3 * run[f"{stroke}_stroke_time"] for stroke in ("opening", "closing")]
    print(f"{friction:>9}: the piston crosses in {times[0]:.2f} ms as it opens, in {times[1]:.2f} ms as it closes")
opening.set(xlim=(4, 16), xlabel="time after the command [ms]", ylabel="lift [mm]", title="opening, 0.49 MPa gauge")
closing.set(xlim=(54, 66), xlabel="time after the command [ms]", title="closing, 0.49 MPa gauge")
opening.legend(title="added friction")

# %%
# Torque of the engine
# --------------------
# The strength is swept like any key of the machine, here with commands at fixed crank angles.

swept = apesim.sweep(
    machine, ["600 rpm", "900 rpm", "1200 rpm"], intake="epv", timing="fixed", vary={key: "0:120:30 N s/m"}
)
data = swept.dataset.squeeze("actuation").rename(effects_tapered_bore_friction="friction")
change = data["brake_torque"] - data["brake_torque"].sel(friction=0.0)

figure, axis = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
for speed in data["speed_rpm"].values:
    axis.plot(data["friction"], change.sel(speed_rpm=speed), "o-", label=f"{speed:.0f} r/min")
    without, most = data["valve_close_deg"].sel(speed_rpm=speed).isel(friction=[0, -1]).values
    print(f"{speed:4.0f} r/min: the intake closes at {without:.1f} deg without it, at {most:.1f} deg at its largest")
axis.axhline(0.0, color="0.6", linewidth=0.8)
axis.set(xlabel="added friction where open [N s/m]", ylabel="change of brake torque [N m]")
axis.set_title("1.0 MPa gauge, 287 K, fixed command angles")
axis.legend()

plt.show()

# %%
# The rings slow the second half of the opening flight and the first half of the closing flight. In the engine the
# intake opens less quickly, which costs torque. It also closes later, which admits more air. At the lowest speed the
# later closing wins, at the higher speeds the slower opening.
#
# The figures do not show whether a real bore behaves so. ``apesim.explain(machine, folder)`` searches measured data for
# this effect, too, beside those of the library. :doc:`/missing_effect/outside_effects` says what such a file may hold.
