"""Figures of the EPV paper (doi 10.1631/jzus.A0820373), as the model gives them."""

from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from apesim.archive import Archive
from apesim.engine.machine import Machine
from apesim.studies.discharge import Discharge, Vessel
from apesim.studies.discharge.figures import plot_areas, plot_pressures
from apesim.studies.drawing.conditions import CONTROL_AIR, VALVE_SECTIONS, conditions_of
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.panels import add_legend, label_axes, open_column, open_one, open_panels
from apesim.studies.drawing.style import BLUE, RED, STYLES, Look, colours_of
from apesim.studies.limit.valve_figures import plot_map, plot_velocities
from apesim.studies.paper.discharge import NOISE, RATE, area_at
from apesim.studies.paper.friction.friction_map import PAPERS, SEARCHED, FrictionMap, conditions_in_words
from apesim.studies.paper.friction.statements import STATEMENTS
from apesim.studies.run.operating_conditions import with_control_air
from apesim.valve.bench import run_bench

PULSE = 50e-3
"""Time for which the solenoids are energised in Figs. 6 and 7 [s]."""
TEMPERATURE = 287.0
"""Temperature of the control air in Figs. 6 and 7 [K]."""
LIFT_PRESSURES = (0.16, 0.40, 0.49)
"""Control pressures of Fig. 6 [MPa gauge]."""
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
"""Captions by name of the figure, with places for what was chosen."""
MAP_SHADES = 10
"""Shades of the map of frictions: with more than 50 a colour bar is no longer drawn as vectors."""


def captions_of(vessel: Vessel, frictions: FrictionMap) -> dict[str, str]:
    """Captions of the figures, by name, with what was chosen for the discharge tests and the map of frictions."""
    chosen = {"volume": vessel.volume * 1e6, "noise": NOISE / 1e3, "rate": RATE / 1e3}
    words = {"conditions": conditions_in_words(frictions)}
    return {name: caption.format(**chosen, **words) for name, caption in CAPTIONS.items()}


def paper_figures(
    machine: Machine, archive: Archive, discharge: Discharge, frictions: FrictionMap, folder: str | PathLike[str]
) -> list[Path]:
    """Write all figures of the paper that the valve's model gives, as PNG and PDF.

    `archive` is the map over the paper's grid, `discharge` the result of the model's own discharge tests; `folder` is
    made if it does not exist.
    """
    ambient = machine.ambient.pressure
    figures = {
        "fig03_discharge": partial(plot_pressures, discharge),
        "fig04_effective_area": partial(plot_areas, discharge, partial(area_at, machine)),
        "fig06_lift": partial(_plot_lifts, machine),
        "fig07_measures": partial(_plot_measures, machine),
        "fig08_delay_time": partial(plot_map, archive, ambient, "delay_time"),
        "fig09_velocity": partial(plot_velocities, archive, ambient),
        "fig10_stroke_time": partial(plot_map, archive, ambient, "stroke_time"),
        "fig11_seating_speed": partial(plot_map, archive, ambient, "seating_speed"),
        "friction_map": partial(_plot_frictions, frictions),
    }
    conditions = conditions_of(archive.machine, CONTROL_AIR, sections=VALVE_SECTIONS)
    return write_figures(figures, folder, conditions)


def _plot_lifts(machine: Machine) -> Figure:
    """Plot the lift over time at 0.16, 0.40 and 0.49 MPa gauge (Fig. 6)."""
    figure, axis = open_one((6.4, 3.7))
    colours = colours_of(len(LIFT_PRESSURES))
    for pressure, colour, style in zip(LIFT_PRESSURES, colours, STYLES, strict=False):
        supplied = with_control_air(machine, machine.ambient.pressure + pressure * 1e6, TEMPERATURE)
        run = run_bench(supplied, PULSE)
        look: Look = {"color": colour, "ls": style, "label": f"{pressure:.2f} MPa gauge"}
        axis.plot(run.times * 1e3, run.trace[:, 0] * 1e3, **look)
    axis.axvspan(0.0, PULSE * 1e3, color="0.94", zorder=0, label="solenoids energised")
    label_axes(axis, x=("time", "ms"), y=("lift", "mm"))
    axis.set_xlim(0.0, 2e3 * PULSE)
    axis.set_ylim(bottom=0.0)
    add_legend(axis)
    return figure


def _plot_measures(machine: Machine) -> Figure:
    """Plot what delay time, full stroke time and seating speed of an opening are, at 1.0 MPa gauge (Fig. 7)."""
    run = run_bench(with_control_air(machine, machine.ambient.pressure + 1.0e6, TEMPERATURE), PULSE, sample=2e-5)
    stroke: Any = run.opening
    delay, contact = stroke.delay * 1e3, stroke.contact * 1e3
    time, lift, speed = run.times * 1e3, run.trace[:, 0] * 1e3, run.trace[:, 1]
    speed = np.where(time < contact, speed, np.nan)
    height = 0.82 * machine.valve.stroke * 1e3
    figure, (above, below) = open_column(2, (6.4, 4.6))
    above.plot(time, lift, color=RED)
    below.plot(time, speed, color=BLUE)
    for axis in (above, below):
        for instant in (delay, contact):
            axis.axvline(instant, color="0.6", lw=0.8, ls="--")
        axis.set_ylim(bottom=0.0)
    for start, end, name in ((0.0, delay, "$t_d$"), (delay, contact, "$t_f$")):
        above.annotate("", (start, height), (end, height), arrowprops={"arrowstyle": "<->", "color": "0.3"})
        above.annotate(name, (0.5 * (start + end) - 0.6, 1.01 * height), ha="center", va="bottom")
    below.annotate("$v_e$", (contact, stroke.seating_speed), (contact + 0.4, stroke.seating_speed), va="center")
    below.plot(contact, stroke.seating_speed, "o", color=BLUE)
    label_axes(above, y=("lift", "mm"))
    label_axes(below, x=("time after the command", "ms"), y=("speed", "m/s"))
    below.set_xlim(0.0, contact + 2.0)
    return figure


def _plot_frictions(frictions: FrictionMap) -> Figure:
    """Plot where the statements on Figs. 9 to 11 hold, over friction and the solenoids' area."""
    figure, panels = open_panels(2, 3, (9.2, 6.4), sharex=True, sharey=True)
    colours = matplotlib.colormaps["Blues"].resampled(MAP_SHADES)

    # The axes count cells, as areas and frictions are not evenly spaced; published values are brought to that count.
    columns, rows = np.arange(len(frictions.areas)), np.arange(len(frictions.frictions))
    published, *searched = np.interp((PAPERS, *SEARCHED), frictions.frictions, rows)
    for axis, statement in zip(panels.flat, STATEMENTS, strict=True):
        share = frictions.holds[statement.key].mean(axis=(2, 3))
        shares = axis.pcolormesh(columns, rows, share, vmin=0.0, vmax=1.0, cmap=colours, shading="nearest")
        axis.axhline(published, color=RED, lw=1.4)
        axis.axhspan(*searched, facecolor="none", edgecolor=RED, hatch="///", alpha=0.35, lw=0.0)
        axis.set_title(statement.name)
        axis.grid(False)
        axis.set_xticks(columns, [f"{area:g}" for area in frictions.areas * 1e6], fontsize=8)
        axis.set_yticks(rows, [f"{friction:g}" for friction in frictions.frictions])

    # Names stand at the outer panels alone, as all of them share their axes.
    for axis in panels[:, 0]:
        label_axes(axis, y=("viscous friction", "N s/m"))
    for axis in panels[-1]:
        label_axes(axis, x=("effective area", "mm²"))

    # What was varied and what the red marks are, in words: there is no legend.
    ramps, temperatures = (
        ", ".join(f"{value:g}" for value in axis) for axis in (frictions.ramps * 1e3, frictions.temperatures)
    )
    pressures = frictions.pressures / 1e6
    figure.suptitle(
        f"What the text says of Figs. 9-11, over {len(pressures)} pressures, {pressures[0]:.1f} to "
        f"{pressures[-1]:.1f} MPa gauge. Red: the published {PAPERS:g} N s/m; hatched: its search",
        fontsize=10,
    )

    # All panels have the scale from 0 to 1, so that the colours of the last one stand for all.
    label = f"share of ramps ({ramps} ms) and temperatures ({temperatures} K) [-]"
    figure.colorbar(shares, ax=panels, label=label, aspect=35)
    return figure
