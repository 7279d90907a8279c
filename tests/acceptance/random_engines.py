"""Engines with anything at random: what they state of their own error, and how far they really are off."""

from collections.abc import Callable, Iterator, Sequence
from math import inf
from typing import Any, NamedTuple

import numpy as np

from apesim.air import IDEAL, THERMALLY_PERFECT
from apesim.engine.angles import DEGREE
from apesim.engine.cycle.state import engine_ledger
from apesim.engine.indicators import indicators
from apesim.engine.machine import Machine
from apesim.engine.steady import SteadyRun, run_steady
from apesim.march.error_bounds import MAX_TOLERANCE_CHANGE
from tests.machines import RPM, machine

FINE = 1e-9
"""Tolerance whose results stand for the true ones: a hundredth of the default."""
FINE_PERIODIC = 1e-10
"""Change of a state over a cycle that counts as periodic there."""


def random_engine(real: Callable[[float, float], float], choice: Callable[[Sequence], Any]) -> tuple[Machine, float]:
    """A machine and its speed [r/min], from a source of numbers between two ends and of one out of several."""
    flag = (False, True)
    stroke = real(60e-3, 160e-3)
    opens = real(-60.0, 30.0)
    closes = opens + real(25.0, 170.0)
    flank = min(25.0, 0.5 * (closes - opens)) * DEGREE
    exhaust_opens, exhaust_closes = real(120.0, 200.0), real(260.0, 350.0)
    area = real(20e-6, 400e-6)
    hot, correlated, leaky, worn = (choice(flag) for _ in range(4))
    return machine(
        air__model=choice((IDEAL, THERMALLY_PERFECT)),
        intake=choice(("epv", "cam", "ideal")),
        supply=real(0.2, 3.0),
        temperature=real(250.0, 350.0),
        ambient__temperature=real(240.0, 340.0),
        energise=opens,
        release=closes,
        targets=(opens, closes),
        receiver=choice((inf, 0.3, 1.0, 10.0)),
        control_air=choice(("regulator", "receiver")),
        engine__bore=real(50e-3, 150e-3),
        engine__stroke=stroke,
        engine__rod_length=stroke * real(1.2, 3.0),
        engine__pin_offset=stroke * real(-0.15, 0.15),
        engine__compression_ratio=real(5.0, 30.0),
        groove__effective_area=area,
        engine__cam__opens=opens * DEGREE,
        engine__cam__closes=closes * DEGREE,
        engine__cam__flank=flank,
        engine__exhaust__effective_area=area * real(0.5, 5.0),
        engine__exhaust__opens=exhaust_opens * DEGREE,
        engine__exhaust__closes=exhaust_closes * DEGREE,
        effects__cylinder_wall_heat__h=hot * real(1.0, 500.0),
        effects__cylinder_wall_heat__wall_temperature=real(250.0, 350.0),
        effects__cylinder_wall_heat__factor=correlated * real(0.1, 5.0),
        effects__cylinder_wall_heat__correlation=choice(range(4)),
        effects__blow_by__area=leaky * real(0.01e-6, 1e-6),
        effects__ring_leakage__area=worn * real(0.01e-6, 0.3e-6),
        effects__coulomb_friction__force=worn * real(0.0, 12.0),
        effects__bounce__restitution=worn * real(0.0, 0.6),
        effects__solenoid_b_delay__time=worn * real(-1e-3, 1e-3),
    ), real(200.0, 2400.0)


class Errors(NamedTuple):
    """Relative errors of an operating point, stated and true, and how well its balances close."""

    work_stated: float
    work: float
    air_stated: float
    air: float
    closures: tuple[float, float, float]
    """Mass, energy, exergy."""
    warned: bool
    """Whether the run warns of its tolerance."""


def errors_of(a_machine: Machine, rpm: float) -> Errors | None:
    """Errors of a machine at a speed [r/min]; None where it does not come to a periodic state."""
    run = run_steady(a_machine, rpm * RPM, angle_step=10.0 * DEGREE)
    fine = run_steady(
        a_machine,
        rpm * RPM,
        tolerance=FINE,
        angle_step=10.0 * DEGREE,
        periodic_tolerance=FINE_PERIODIC,
        estimate_error=False,
    )
    if not (run.orbit.converged and fine.orbit.converged):
        return None
    found = indicators(a_machine, run)
    return Errors(
        run.work_change,
        _off(_work(run), _work(fine)),
        run.air_change,
        _off(_air(run), _air(fine)),
        (found["mass_closure"], found["energy_closure"], found["exergy_closure"]),
        max(run.work_change, run.air_change) > MAX_TOLERANCE_CHANGE,
    )


def random_errors(count: int, seed: int = 0) -> Iterator[Errors]:
    """Errors of so many random engines; those without a periodic state are left out."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        drawn = random_engine(
            lambda low, high: float(random.uniform(low, high)), lambda of: of[random.integers(len(of))]
        )
        errors = errors_of(*drawn)
        if errors:
            yield errors


def _work(run: SteadyRun) -> float:
    return engine_ledger(run.end).work


def _air(run: SteadyRun) -> float:
    return engine_ledger(run.end).groove.mass


def _off(value: float, true: float) -> float:
    return 0.0 if value == true else abs(value / true - 1.0)
