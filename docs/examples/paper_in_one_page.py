"""
The EPV paper in one page
=========================

What does the model say of the EPV paper (`doi 10.1631/jzus.A0820373 <https://doi.org/10.1631/jzus.A0820373>`_)? This
example draws the paper's main figures, as the model gives them, and prints a table of the paper's claims with a verdict
on each.
"""

import matplotlib.pyplot as plt

import apesim

machine = apesim.Machine()  # its valve is that of the paper's Table 1

# %%
# One pulse at 0.49 MPa gauge: lift (the paper's Fig. 6) and the pressures of both chambers.

run = apesim.run_valve(machine, supply="0.49 MPa gauge", temperature="287 K", pulse="50 ms")
figure, (above, below) = plt.subplots(2, 1, figsize=(6.4, 5.4), sharex=True, layout="constrained")
run.plot(above)
run.plot(below, "pressures")
above.set(xlabel="", title="0.49 MPa gauge, 287 K, pulse of 50 ms")
below.set_title("")
print(run)

# %%
# Delay time and full stroke time of the opening over pressure and temperature (Figs. 8 and 10). The delay time ends
# where the piston has moved; the stroke time is what it then needs to the open stop.

mapped = apesim.map_valve(machine, pressure="0.1:1.9:0.1 MPa gauge", temperature="250 K, 287 K, 322 K")
data = mapped.to_pandas()
figure, axes = plt.subplots(2, 1, figsize=(6.4, 5.4), sharex=True, layout="constrained")
for axis, name in zip(axes, ("opening_delay", "opening_stroke_time"), strict=True):
    for temperature, line in data.groupby("supply_temperature"):
        pressure = (line["supply_pressure"] - machine.ambient.pressure) / 1e6
        axis.plot(pressure, 1e3 * line[name], ".-", label=f"{temperature:.0f} K")
axes[0].set(ylabel="delay time [ms]", title="opening, 50 ms pulse")
axes[1].set(xlabel="supply pressure [MPa gauge]", ylabel="full stroke time [ms]")
axes[0].legend(title="control air")

# %%
# The claims, each judged on the model. ``scope="claims"`` judges them at the machine's own solenoid area, 9 mm², which
# the paper does not print. The full repetition, ``apesim paper --out DIR`` on the command line, also says for which
# areas each verdict holds; it takes some thirty seconds.

paper = apesim.repeat_paper(machine, scope="claims")
print(f"{paper['claims']} claims: {paper['reproduced']} reproduced, {paper['contradicted']} contradicted")
for claim in paper.claims:
    print(f"\n{claim.where}: {claim.claim}\n  model: {claim.ours}\n  {claim.verdict}")

plt.show()

# %%
# The delay time rises with pressure and falls with temperature; the stroke time falls with both.
#
# The curves show the model alone. The paper's measured curves are not published as numbers, so the figures do not show
# how close the model is to the measured valve. "Contradicted" means that the paper's own equations, with its Table 1
# and a chosen solenoid area, give something else; it is no measurement. See :doc:`/paper`.
