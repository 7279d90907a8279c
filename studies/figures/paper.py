"""Figures of the paper, doi 10.1631/jzus.A0820373, as the model gives them."""

import matplotlib.pyplot as plt
import numpy as np

from apesim.studies.figures.conditions import SUPPLY, conditions_of
from apesim.studies.figures.discharge import areas, pressures
from apesim.studies.figures.style import draw
from apesim.studies.figures.valve import contours, velocities
from apesim.studies.paper.discharge import NOISE, RATE, area_at
from apesim.studies.paper.friction import PAPERS, SEARCHED, conditions_in_words
from apesim.studies.paper.statements import STATEMENTS
from apesim.studies.valve_map import with_supply
from apesim.valve.bench import run_bench

PULSE = 50e-3
TEMPERATURE = 287.0
TESTS = "the model's own discharge tests ({volume:.3g} cm³, {noise:g} kPa noise, {rate:g} kHz), not measured ones"
CAPTIONS = {
    "fig03_discharge": f"Fig. 3. Pressure of the vessel from 0.4, 0.6 and 0.8 MPa gauge: {TESTS}.",
    "fig04_effective_area": f"Fig. 4. Effective area by Eq. 10 from {TESTS}, each with its 95 % band, beside the area "
    "that emptied the vessel.",
    "fig06_lift": "Fig. 6. Lift at the paper's three pressures, 50 ms pulse, 287 K; without the measured curves.",
    "fig07_measures": "Fig. 7. What delay time, full stroke time and seating speed are, at 1.0 MPa gauge and 287 K.",
    "fig08_delay_time": "Fig. 8. Delay time over pressure and temperature.",
    "fig09_velocity": "Fig. 9. Velocity of the piston at several pressures, 290 K.",
    "fig10_stroke_time": "Fig. 10. Full stroke time over pressure and temperature.",
    "fig11_seating_speed": "Fig. 11. Seating speed over pressure and temperature.",
    "friction_map": "What the text says of Figs. 9 to 11, over friction and the solenoids' area: the share of ramps "
    "and temperatures at which each statement holds. The line is the published 111.08 N s/m, hatched what the paper's "
    "algorithm searched. {conditions}",
}


def captions_of(vessel, frictions):
    """The captions, with what was chosen for the discharge tests and for the map of frictions."""
    chosen = {"volume": vessel.volume * 1e6, "noise": NOISE / 1e3, "rate": RATE / 1e3}
    chosen["conditions"] = conditions_in_words(frictions)
    return {name: caption.format(**chosen) for name, caption in CAPTIONS.items()}


def paper_figures(machine, archive, found, frictions, folder):
    """All figures of the paper that the valve's model gives.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    archive : Archive
        The map over the paper's grid.
    found : apesim.studies.discharge.Discharge
        Of the model's own discharge tests.
    frictions : apesim.studies.paper.friction.FrictionMap
    folder : path
        Made if it does not exist.

    Returns
    -------
    list of Path
    """
    ambient = machine.ambient.pressure
    figures = {
        "fig03_discharge": lambda: pressures(found),
        "fig04_effective_area": lambda: areas(found, lambda times: area_at(machine, times)),
        "fig06_lift": lambda: lifts(machine),
        "fig07_measures": lambda: measures(machine),
        "fig08_delay_time": lambda: contours(archive, ambient, "delay_s", 1e3, "delay time [ms]"),
        "fig09_velocity": lambda: velocities(archive, ambient),
        "fig10_stroke_time": lambda: contours(archive, ambient, "stroke_time_s", 1e3, "full stroke time [ms]"),
        "fig11_seating_speed": lambda: contours(archive, ambient, "seating_speed_m_s", 1.0, "seating speed [m/s]"),
        "friction_map": lambda: friction_map(frictions),
    }
    return draw(figures, folder, conditions_of(archive.machine, SUPPLY))


def lifts(machine):
    """Lift over time at 0.16, 0.40 and 0.49 MPa gauge (Fig. 6)."""
    figure, axis = plt.subplots(figsize=(6.4, 3.7), layout="constrained")
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.8, 3))
    for pressure, colour in zip((0.16, 0.40, 0.49), colours, strict=True):
        supplied = with_supply(machine, machine.ambient.pressure + pressure * 1e6, TEMPERATURE)
        run = run_bench(supplied, PULSE)
        axis.plot(run.times * 1e3, run.trace[:, 0] * 1e3, color=colour, label=f"{pressure:.2f} MPa gauge")
    axis.axvspan(0.0, PULSE * 1e3, color="0.94", zorder=0, label="solenoids energised")
    axis.set(xlabel="time [ms]", ylabel="lift [mm]")
    axis.set_xlim(0.0, 2e3 * PULSE)
    axis.set_ylim(bottom=0.0)
    axis.legend(fontsize=8.5, loc="upper right")
    return figure


def measures(machine):
    """The measures of an opening stroke, at 1.0 MPa gauge (Fig. 7)."""
    run = run_bench(with_supply(machine, machine.ambient.pressure + 1.0e6, TEMPERATURE), PULSE, sample=2e-5)
    stroke = run.opening
    delay, contact = stroke.delay * 1e3, stroke.contact * 1e3
    time, lift, speed = run.times * 1e3, run.trace[:, 0] * 1e3, run.trace[:, 1]
    speed = np.where(time < contact, speed, np.nan)
    figure, (above, below) = plt.subplots(2, 1, figsize=(6.4, 4.6), layout="constrained", sharex=True)
    above.plot(time, lift, color="#c1440e")
    below.plot(time, speed, color="#2a6f97")
    for axis in (above, below):
        for instant in (delay, contact):
            axis.axvline(instant, color="0.6", lw=0.8, ls="--")
        axis.set_ylim(bottom=0.0)
    for start, end, name in ((0.0, delay, "$t_d$"), (delay, contact, "$t_f$")):
        above.annotate("", (start, 7.4), (end, 7.4), arrowprops={"arrowstyle": "<->", "color": "0.3"})
        above.annotate(name, (0.5 * (start + end) - 0.6, 7.5), ha="center", va="bottom")
    below.annotate("$v_e$", (contact, stroke.seating_speed), (contact + 0.4, stroke.seating_speed), va="center")
    below.plot(contact, stroke.seating_speed, "o", color="#2a6f97")
    above.set(ylabel="lift [mm]")
    below.set(ylabel="speed [m/s]", xlabel="time after the command [ms]")
    below.set_xlim(0.0, contact + 2.0)
    return figure


def friction_map(found):
    """Draw where the statements on Figs. 9 to 11 hold, over friction and the solenoids' area.

    Parameters
    ----------
    found : apesim.studies.paper.friction.FrictionMap

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = plt.subplots(2, 3, figsize=(9.2, 6.4), layout="constrained", sharex=True, sharey=True)
    colours = plt.get_cmap("Blues", 10)  # with more than 50 a colour bar is no longer drawn as vectors
    columns, rows = np.arange(len(found.areas)), np.arange(len(found.frictions))
    at = np.interp((PAPERS, *SEARCHED), found.frictions, rows)
    for axis, statement in zip(axes.flat, STATEMENTS, strict=True):
        share = found.holds[statement.key].mean(axis=(2, 3))
        shown = axis.pcolormesh(columns, rows, share, vmin=0.0, vmax=1.0, cmap=colours, shading="nearest")
        axis.axhline(at[0], color="#c1440e", lw=1.4)
        axis.axhspan(*at[1:], facecolor="none", edgecolor="#c1440e", hatch="///", alpha=0.35, lw=0.0)
        axis.set_title(statement.name)
        axis.grid(False)
        axis.set_xticks(columns, [f"{area:g}" for area in found.areas * 1e6], fontsize=8)
        axis.set_yticks(rows, [f"{friction:g}" for friction in found.frictions])
    for axis in axes[:, 0]:
        axis.set_ylabel("viscous friction [N s/m]")
    for axis in axes[-1]:
        axis.set_xlabel("effective area [mm²]")
    ramps, temperatures = (
        ", ".join(f"{value:g}" for value in axis) for axis in (found.ramps * 1e3, found.temperatures)
    )
    figure.suptitle(
        f"What the text says of Figs. 9-11, over {len(found.pressures)} pressures, {found.pressures[0] / 1e6:.1f} to "
        f"{found.pressures[-1] / 1e6:.1f} MPa gauge. Red: the published {PAPERS:g} N s/m; hatched: its search",
        fontsize=10,
    )
    figure.colorbar(shown, ax=axes, label=f"share of ramps ({ramps} ms) and temperatures ({temperatures} K)", aspect=35)
    return figure
