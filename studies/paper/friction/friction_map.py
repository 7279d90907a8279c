"""What the text says of Figs. 9 to 11, over friction, and over the solenoids' area and ramp, which are not printed."""

from collections.abc import Callable, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.execution.pool import Team
from apesim.studies.limit.valve_map import PULSE
from apesim.studies.paper.claims.area import with_area
from apesim.studies.paper.claims.claim import AREA, Claim, range_of, verdict_of, with_range
from apesim.studies.paper.claims.stroke import min_difference
from apesim.studies.paper.friction.statements import STATEMENTS
from apesim.studies.run.operating_conditions import with_control_air
from apesim.valve.bench import run_bench

PAPERS = 111.08
"""The paper's viscous friction [N s/m]."""
SEARCHED = (100.0, 120.0)
"""Range in which its genetic algorithm looked for it (Table 2) [N s/m]."""
FRICTIONS: tuple[float, ...] = (*np.arange(0.0, 101.0, 10.0), PAPERS, 120.0)
AREAS = (*np.arange(3.0, 11.1, 1.0) * 1e-6, 12.5e-6)
"""Effective areas of the solenoids, as far as `apesim.studies.paper.claims.area.AREAS` [m2]."""
RAMPS = (0.1e-3, 1.5e-3, 8e-3)
"""Ramp times of the solenoids: next to none, the default, a period of their 120 Hz [s]."""
PRESSURES = np.arange(0.1, 2.0, 0.2) * 1e6
"""Control pressures, the paper's [Pa gauge]."""
TEMPERATURES = (250.0, 287.0, 322.0)
"""The ends of the paper's range, and its T_0 [K]."""
MEASURES = ("delay", "stroke_time", "seating_speed", "fluctuation", "reverses")
"""Fields of `apesim.valve.measures.Stroke` that the statements are about."""


class FrictionMap(NamedTuple):
    """Map of where the statements hold, over friction and what the paper does not print."""

    frictions: np.ndarray
    """[N s/m], shape (f,)"""
    areas: np.ndarray
    """[m2], shape (a,)"""
    ramps: np.ndarray
    """[s], shape (r,)"""
    temperatures: np.ndarray
    """[K], shape (t,)"""
    pressures: np.ndarray
    """[Pa gauge], shape (n,)"""
    holds: dict[str, np.ndarray]
    """Answers by key of the statement: 1 or 0, NaN where a stroke is not completed; shape (f, a, r, t)."""

    def row_of(self, friction: float) -> int:
        """Find the row of the friction of the map that is nearest to a viscous friction [N s/m]."""
        return int(np.argmin(np.abs(self.frictions - friction)))

    def everywhere(self, key: str) -> float | None:
        """Find the highest friction [N s/m] up to which a statement holds at all areas, ramps and temperatures.

        `key` is one of `apesim.studies.paper.friction.statements.STATEMENTS`; None: it holds so at none.
        """
        always = np.all(self.holds[key] == 1.0, axis=(1, 2, 3))
        rows = len(always) if always.all() else int(np.argmin(always))
        return float(self.frictions[rows - 1]) if rows else None

    def anywhere(self, key: str) -> float | None:
        """Find the highest friction [N s/m] at which a statement holds at any area, ramp and temperature.

        `key` is one of `apesim.studies.paper.friction.statements.STATEMENTS`; None: it holds at none.
        """
        ever = np.flatnonzero(np.any(self.holds[key] == 1.0, axis=(1, 2, 3)))
        return float(self.frictions[ever[-1]]) if len(ever) else None

    def max_at_once(self, friction: float) -> int:
        """Count the statements that hold at once, over all temperatures, at the area and ramp where most do.

        The friction of the map nearest to `friction` [N s/m] is taken.

        >>> axis, yes, no = np.ones(1), np.ones((1, 1, 1, 1)), np.zeros((1, 1, 1, 1))
        >>> FrictionMap(np.array([10.0]), axis, axis, axis, axis, {"rebound": no, "response": yes}).max_at_once(10.0)
        1
        """
        row = self.row_of(friction)
        return int(sum(np.all(holds[row] == 1.0, axis=-1) for holds in self.holds.values()).max())


def map_friction(
    machine: Machine,
    frictions: Sequence[float] = FRICTIONS,
    areas: Sequence[float] = AREAS,
    ramps: Sequence[float] = RAMPS,
    temperatures: Sequence[float] = TEMPERATURES,
    pressures: Sequence[float] | np.ndarray = PRESSURES,
    report: Callable[[int, int], object] | None = None,
    team: Team | None = None,
) -> FrictionMap:
    """Judge opening strokes over friction, area and ramp of the solenoids, temperature and pressure, by the statements.

    The statements are those of the EPV paper (doi 10.1631/jzus.A0820373) on its Figs. 9 to 11. Viscous frictions [N
    s/m] and control pressures [Pa gauge] ascend; areas are in m2, ramp times in s, temperatures of the control air in
    K. Where the machine has an opening curve of its own it stands for the ramps. `report` is called with the numbers of
    cells done and in all; without a `team` this process alone computes.
    """
    ramps = ramps if not len(machine.valve.solenoid.opening_curve) else (machine.valve.solenoid.ramp_time,)
    cells = list(product(frictions, areas, ramps))
    calls = [(_with_cell(machine, *cell), temperatures, pressures) for cell in cells]
    rows = (team or Team()).map(_held, calls, report)
    shape = len(frictions), len(areas), len(ramps), len(temperatures)
    holds = {statement.key: np.array([row[i] for row in rows]).reshape(shape) for i, statement in enumerate(STATEMENTS)}
    f, a, r, t, n = (np.array(axis) for axis in (frictions, areas, ramps, temperatures, pressures))
    return FrictionMap(f, a, r, t, n, holds)


def _with_cell(machine: Machine, friction: float, area: float, ramp: float) -> Machine:
    """A machine with a friction [N s/m], and an area [m2] and a ramp [s] of its solenoids."""
    valve = with_area(machine, area).valve
    solenoid = valve.solenoid._replace(ramp_time=float(ramp))
    return machine._replace(valve=valve._replace(viscous_friction=float(friction), solenoid=solenoid))


def _held(machine: Machine, temperatures: Sequence[float], pressures: Sequence[float] | np.ndarray) -> list[np.ndarray]:
    """Find which statements hold: a row for each, over temperature."""
    strokes = {name: np.empty((len(pressures), len(temperatures))) for name in (*MEASURES, "least_difference")}
    for at in np.ndindex(len(pressures), len(temperatures)):
        pressure, temperature = float(pressures[at[0]]), temperatures[at[1]]
        run = run_bench(with_control_air(machine, machine.ambient.pressure + pressure, temperature), PULSE, until=PULSE)
        for name in MEASURES:
            strokes[name][at] = getattr(run.opening, name)
        strokes["least_difference"][at] = min_difference(run)
    complete = np.all(np.isfinite(strokes["stroke_time"]), axis=0)
    return [np.where(complete, statement.holds(strokes), np.nan) for statement in STATEMENTS]


def viscous_friction(friction_map: FrictionMap) -> Claim:
    """Judge the published 111.08 N s/m by what the text says of the figures.

    The number and how it was found stand in [EPV, section on simulation setting and experimental validation], the
    search in its Table 2.
    """
    row, count = friction_map.row_of(PAPERS), len(STATEMENTS)

    # How many statements hold at once at the published friction, and how many at the best one.
    papers = friction_map.max_at_once(PAPERS)
    highest = max(friction_map.max_at_once(friction) for friction in friction_map.frictions)
    areas, ramps = friction_map.areas * 1e6, friction_map.ramps * 1e3

    # Each statement by itself: in which share of the conditions it holds there, and up to which friction at all.
    shares = {s.key: float(friction_map.holds[s.key][row].mean()) for s in STATEMENTS}
    never = ", ".join(s.name.replace("$", "") for s in STATEMENTS if shares[s.key] == 0.0)
    values: dict[str, Any] = {"statements": count, "most_at_once": papers, "most_at_once_at_any_friction": highest}
    for s in STATEMENTS:
        values[f"{s.key}_share_of_conditions"] = shares[s.key]
        values[f"{s.key}_in_all_conditions_up_to_N_s_per_m"] = friction_map.everywhere(s.key)
        values[f"{s.key}_in_any_condition_up_to_N_s_per_m"] = friction_map.anywhere(s.key)

    # The answer names two of them: up to which friction each holds in all conditions, and in some.
    ends = [
        end(key)
        for key in ("stroke_time", "pressure_inversion")
        for end in (friction_map.everywhere, friction_map.anywhere)
    ]
    texts = ["no friction" if end is None else f"{end:g} N s/m" for end in ends]
    claim = Claim(
        "viscous_friction",
        "experimental validation, Figs. 9-11",
        "The viscous friction coefficient is 111.08 N s/m.",
        f"{PAPERS:g} N s/m",
        f"at {PAPERS:g} N s/m no effective area from {areas[0]:g} to {areas[-1]:g} mm² and no "
        f"ramp from {ramps[0]:g} to {ramps[-1]:g} ms gives more than {papers} of {count} "
        f"statements of the text on Figs. 9-11; none gives: {never or '-'}. Less friction gives up to {highest}: "
        f"t_f is not monotonic in all conditions up to {texts[0]}, in some up to {texts[1]}; the pressure turns round "
        f"in all up to {texts[2]}, in some up to {texts[3]}",
        values,
        verdict_of(papers == count),
        "The fit cannot be repeated: the measured curves survive as figures only. Its result contradicts what the text "
        f"says of the motion; the search went from {SEARCHED[0]:g} to {SEARCHED[1]:g} N s/m (Table 2). "
        "The figure friction_map shows it.",
    )

    # The paper does not print the solenoids' area, so that there is a verdict for each, at the ramp where most holds.
    by_area = sum(np.all(friction_map.holds[s.key][row] == 1.0, axis=-1) for s in STATEMENTS).max(axis=-1)
    claims = [
        claim._replace(ours=f"at most {n} of {count} statements", verdict=verdict_of(n == count)) for n in by_area
    ]
    return with_range(claim, range_of(AREA, "mm^2", areas.round(6).tolist(), claims))


def conditions_in_words(friction_map: FrictionMap) -> str:
    """Say over what the map was made, with its resolution, in a sentence."""
    areas, ramps, frictions = friction_map.areas * 1e6, friction_map.ramps * 1e3, friction_map.frictions
    temperatures, pressures = ", ".join(f"{t:g}" for t in friction_map.temperatures), friction_map.pressures / 1e6
    return (
        f"Opening strokes at {len(frictions)} frictions from {frictions[0]:g} to {frictions[-1]:g} "
        f"N s/m, {len(areas)} effective areas from {areas[0]:g} to {areas[-1]:g} mm², ramps of "
        f"{', '.join(f'{r:g}' for r in ramps)} ms, {temperatures} K and {len(pressures)} pressures from "
        f"{pressures[0]:.1f} to {pressures[-1]:.1f} MPa gauge; all else as in the machine."
    )


def friction_table(friction_map: FrictionMap) -> tuple[list[str], np.ndarray]:
    """Table of the map: shares of the temperatures at which each statement holds.

    Returns the header, names with units, and the rows, (n, m).
    """
    header = [
        "viscous_friction [N s/m]",
        "effective_area [mm^2]",
        "ramp_time [ms]",
        *(f"{s.key} [-]" for s in STATEMENTS),
    ]
    axes = np.meshgrid(friction_map.frictions, friction_map.areas * 1e6, friction_map.ramps * 1e3, indexing="ij")
    shares = [friction_map.holds[s.key].mean(axis=-1) for s in STATEMENTS]
    return header, np.column_stack([column.ravel() for column in (*axes, *shares)])
