"""
A machine of one's own
======================

Bore, stroke, valve and cam stand in a machine file. This example writes a small one, shows what a wrong key or value
gives, and then runs a published engine from its machine file, next to what was measured on it.

It reads files of the folder ``data``, which a download does not hold: copy ``docs/examples/data`` of the source code
beside the script.
"""

from pathlib import Path

import matplotlib.pyplot as plt

import apesim

# %%
# A machine file
# --------------
# It is a TOML file. What it leaves out has its default, and every quantity carries its unit.

out = Path("out")
out.mkdir(exist_ok=True)
mine = out / "mine.toml"
mine.write_text("""
[supply]
pressure = "0.8 MPa gauge"

[engine]
intake = "cam"
bore = "70 mm"
stroke = "65 mm"
rod_length = "110 mm"
compression_ratio = 12.0

[engine.cam]
opens = "-5 deg"
closes = "90 deg"
lift = "8 mm"
""")
machine = apesim.Machine.load(mine)
print(machine)
print(apesim.run_engine(machine, speed="1200 rpm"))

# %%
# ``to_toml`` (``apesim machine`` on the command line) writes all keys, each with its range and the source of its value.
# Here are those of the engine itself; :doc:`/guide/machine_file` lists all.

text = machine.to_toml()
print(text[text.index("[engine]") : text.index("[engine.cam]")])

# %%
# What is wrong is refused, all faults at once, each with its remedy:

mine.write_text("""
[engine]
bore = 70
strok = "65 mm"
compression_ratio = 0.5

[supply]
pressure = "0.8 MPa"
""")
try:
    apesim.Machine.load(mine)
except apesim.InputError as error:
    print(error)

# %%
# A published engine
# ------------------
# Huang et al. (doi 10.3390/en6031731) ran a 100 cm³ motorcycle engine on air at 9 bar abs. They give the highest brake
# torque, 9.99 N·m at 465 r/min, and the highest brake power, 0.95 kW at 1320 r/min. ``data/huang.toml`` names each of
# its assumptions: bore, valve areas and valve timing are not published.

huang = apesim.Machine.load("data/huang.toml")
speeds = [300, 465, 600, 800, 1000, 1200, 1320, 1500, 1800]
swept = apesim.sweep(huang, [f"{speed} rpm" for speed in speeds], intake="cam")
table = swept.to_pandas()
figure, (above, below) = plt.subplots(2, 1, figsize=(6.4, 5.6), sharex=True, layout="constrained")
above.plot(table["speed_rpm"], table["brake_torque"], "o-", label="computed")
above.plot(465.0, 9.99, "ks", label="published, highest torque")
below.plot(table["speed_rpm"], table["brake_power"] / 1e3, "o-", label="computed")
below.plot(1320.0, 0.95, "ks", label="published, highest power")
above.set(ylabel="brake torque [N m]", title="100 cm³ engine, 9 bar abs")
below.set(xlabel="speed [r/min]", ylabel="brake power [kW]")
above.legend()
below.legend()

torque = table.set_index("speed_rpm")["brake_torque"].loc[465.0]
power = table.set_index("speed_rpm")["brake_power"].loc[1320.0] / 1e3
print(f"torque at 465 r/min: {torque:.2f} N m computed, 9.99 N m published: {torque / 9.99 - 1:+.1%}")
print(f"power at 1320 r/min: {power:.3f} kW computed, 0.95 kW published: {power / 0.95 - 1:+.1%}")

plt.show()

# %%
# Two published points say little about a whole curve. The torque at low speed follows from the supply's pressure over
# most of a stroke, less the return stroke and friction. The power depends strongly on the exhaust valve's assumed area.
#
# The figure does not show what each assumption is worth, nor that the outlet was measured above atmospheric pressure,
# where the example exhausts to the atmosphere. Both stand in :doc:`/validation/huang`.
