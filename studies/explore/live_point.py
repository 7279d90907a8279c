"""One operating point for the page: quickly, from the state that is shown, while a slider moves; exactly at rest."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from apesim.effect import kind_of_march
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
from apesim.engine.cycle.state import Cycle
from apesim.engine.cylinder import IDEAL_VALVE
from apesim.engine.drivetrain.point import PointRun, point_of, run_point
from apesim.engine.effects import library_of
from apesim.engine.machine import Machine
from apesim.engine.steady import is_of_one_cylinder, run_steady
from apesim.march.adaptive import Status
from apesim.march.periodic import Known
from apesim.quantities import split_header

FIRST_ANGLE = -60.0
"""Crank angle at which the curves begin [deg]: intake and expansion are seen in one piece."""
ANGLES = FIRST_ANGLE + np.arange(361.0)
"""Crank angles of all curves [deg]; the last is the first one, a turn later."""
MAX_QUICK_CYCLES = 300
"""Cycles after which a quick march is shown as it is, with its warning: a slow machine is to answer, too."""
COLUMNS = tuple(split_header(header)[0] for header in TRACE)
"""Names of the columns of a trace."""
SHOWN = (
    "lift",
    "pressure_a",
    "pressure_b",
    "cylinder_pressure",
    "receiver_pressure",
    "torque",
    "groove_flow",
    "cylinder_temperature",
    "cylinder_volume",
)
"""Curves that the page shows."""


class LivePoint(NamedTuple):
    """Operating point, as the page shows it."""

    numbers: Mapping[str, Any]
    """Indicators by their names in files; NaN where the march ended early."""
    curves: Mapping[str, np.ndarray]
    """Curves at `ANGLES`, by name; none where the march ended early."""
    warnings: Sequence[str]


class Shown(NamedTuple):
    """Periodic state that is shown, from which the next one is searched."""

    kind: tuple[Any, ...]
    """Kind of machine that it is of, see `march_kind`."""
    known: Known
    at_rest: np.ndarray
    """State of that machine at rest, charged, (SIZE,)."""

    def moved_to(self, p: Cycle) -> Known:
        """Move it to another machine of its kind: the air is more or less as it would be at rest.

        Where a volume or the supply has changed, masses and energies of the air change with it.
        """
        at_rest, _ = charged_at_rest(p)
        is_held = self.at_rest != 0.0
        shares = np.divide(at_rest, self.at_rest, out=np.ones_like(at_rest), where=is_held)
        return self.known._replace(y=self.known.y * shares)


class States(dict[bool, Shown]):
    """Periodic state that is shown under False, that with an ideal valve under True."""


def run_live(machine: Machine, speed: float, states: States, *, is_exact: bool) -> tuple[LivePoint, LivePoint]:
    """Run a machine, and with an ideal valve, at a speed [rad/s]; updates the states that the next run starts from.

    Where it is exact, the numbers are those of `apesim.run_engine`: from rest, with its error and its exergy.
    """
    ideal = machine._replace(engine=machine.engine._replace(intake=IDEAL_VALVE))
    own = _run_one(machine, speed, states, is_exact=is_exact, is_ideal=False)
    if machine.engine.intake == IDEAL_VALVE:
        return own, own
    return own, _run_one(ideal, speed, states, is_exact=is_exact, is_ideal=True)


def march_kind(machine: Machine) -> tuple[Any, ...]:
    """What of a machine decides which march it needs, and whether a state of another is one of it."""
    library = library_of(machine.effects)
    on = tuple(effect.name for effect in library if effect.is_on(getattr(machine.effects, effect.name)))
    kind = kind_of_march(library, machine.effects)
    return is_of_one_cylinder(machine), kind, len(machine.engine.exhausts), on


def _run_one(machine: Machine, speed: float, states: States, *, is_exact: bool, is_ideal: bool) -> LivePoint:
    """Run a machine of one cylinder from the state that is shown, or any other from rest."""
    if not is_of_one_cylinder(machine):
        point = run_point(machine, speed, angle_step=DEGREE, trace_start=FIRST_ANGLE * DEGREE)
        return _live(point, point.traces[0] if point.traces else None)

    # Rows at the angles of the page, in the order in which the cycle, which begins at the energising, meets them.
    begin = machine.command.energise
    angles = begin + (ANGLES[:-1] * DEGREE - begin) % TURN
    order = np.argsort(angles)
    if is_exact:
        run = run_steady(machine, speed, angles=angles[order])
    else:
        p, _, _ = cycle_of(machine, speed)
        shown = states.get(is_ideal)
        start = shown.moved_to(p) if shown and shown.kind == march_kind(machine) else None
        run = run_steady(
            machine, speed, angles=angles[order], start=start, estimate_error=False, max_cycles=MAX_QUICK_CYCLES
        )
    if run.orbit.known is not None:
        states[is_ideal] = Shown(march_kind(machine), run.orbit.known, charged_at_rest(run.cycle)[0])
    else:
        states.pop(is_ideal, None)
    rows = np.empty_like(run.trace)
    rows[order] = run.trace
    return _live(point_of(machine, run), np.concatenate((rows, rows[:1])))


def _live(point: PointRun, rows: np.ndarray | None) -> LivePoint:
    """Take from a point what the page shows; what ended early shows why, and no curves."""
    if point.run.status != Status.DONE or rows is None:
        return LivePoint(point.values, {}, [f"the march ended early: {Status(point.run.status).remedy}"])
    curves = {name: rows[:, COLUMNS.index(name)] for name in SHOWN}
    return LivePoint(point.values, curves, list(point.warnings.values()))
