"""Valid machines at random, in the engine or on the valve's bench: near the default one, or wide.

Whatever the machine, the march closes and keeps within its bounds, or it is said in one line why not, within `SLOWEST`.
"""

import time

import numpy as np

import apesim
from apesim.engine.exergy import ENTERS
from apesim.studies.run.operating_conditions import RATE, SPEED

from .campaign import WITH_COMPILER, Outcome
from .draws import draw_log, draw_machine

LONGEST = 120.0
"""That a trial may take beside others on the same cores [s]."""
SLOWEST = 30.0
"""Processor time after which a trial without a result has to have said so [s]."""
MEMORY = WITH_COMPILER
CLOSURE = 1e-6
"""Mass or energy that may be missing, relative."""
EXERGY_CLOSURE = 1e-6
"""Exergy that may be missing without a warning, relative."""
ERROR = 1e-7
"""Relative error by which a lift may miss its bound: the tolerance of a step."""
KINDS = ("engine, near", "valve, near", "engine, wide", "valve, wide")
POSITIVE = "Pa abs", "K", "m3"
"""Units of traces that are nowhere 0 or less."""
OF_THE_VALVE = "velocity", "pressure_a", "pressure_b"
"""Traces that an engine without our valve has not."""


def trial(seed):
    """Run a machine that is drawn at random.

    Parameters
    ----------
    seed : int
        Its remainder by four says which of `KINDS`.

    Returns
    -------
    Outcome
    """
    kind = KINDS[seed % len(KINDS)]
    place, _, width = kind.partition(", ")
    rng = np.random.default_rng(seed)
    machine, begun = draw_machine(rng, width == "wide"), time.process_time()
    try:
        run, ending = (run_engine if place == "engine" else run_valve)(machine, rng, width == "wide"), "closes"
    except apesim.NotConverged as error:
        run, ending = error.result, describe(error)
    except Exception as error:
        return Outcome(f"{kind}: ends with {type(error).__name__}", True, str(error))
    wrong = list(find_faults(machine, run)) if ending in ("closes", "not periodic") else []
    if ending != "closes" and time.process_time() - begun > SLOWEST:
        wrong.append((f"longer than {SLOWEST:g} s", ending))
    if wrong:
        return Outcome(f"{kind}: {wrong[0][0]}", True, "; ".join(f"{what}: {detail}" for what, detail in wrong))
    return Outcome(f"{kind}: {ending}")


def run_engine(machine, rng, is_wide):
    """Run the engine at a speed drawn at random, of the whole range or between 200 and 2400 r/min."""
    low, high = (SPEED.low, SPEED.high) if is_wide else (200.0, 2400.0)
    return apesim.run_engine(machine, speed=f"{draw_log(rng, low, high)!r} rpm")


def run_valve(machine, rng, is_wide):
    """Run the valve on its bench: a pulse drawn at random, of 1 to 1000 ms or of 5 to 100 ms, half of them repeated."""
    low, high = (1e-3, 1.0) if is_wide else (5e-3, 0.1)
    pulse = draw_log(rng, low, high)
    rate = max(RATE.low, min(rng.uniform(0.05, 0.9) / pulse, RATE.high)) if rng.random() < 0.5 else None
    return apesim.run_valve(machine, pulse=pulse, repeat=rate)


def describe(error):
    """How a run failed, in a few words that trials are counted by."""
    if "not periodic" in str(error):
        return "not periodic"
    return f"ended early: {error.remedy.partition(':')[0]}"


def find_faults(machine, run):
    """Find promises that a run breaks.

    Yields
    ------
    what, detail : str
    """
    for name in ("mass_closure", "energy_closure"):
        if not run[name] <= CLOSURE:
            yield f"{name} above {CLOSURE:g}", f"{run[name]:.3g}"
    has_valve = run.conditions.get("intake", "epv") == "epv"
    for name, trace in run.traces.items():
        if name in OF_THE_VALVE and not has_valve:
            continue
        values = np.asarray(trace.values)
        if not np.isfinite(values).all():
            yield f"{name} is no number", f"{np.count_nonzero(~np.isfinite(values))} of {values.size}"
        elif trace.unit in POSITIVE and not values.min() > 0.0:
            yield f"{name} is not above 0", f"{values.min():.6g} {trace.unit}"
    lift, stroke = np.asarray(run.traces["lift"].values), highest_lift(machine, run)
    if not (lift.min() >= -ERROR * stroke and lift.max() <= (1.0 + ERROR) * stroke):
        yield "the lift leaves its stroke", f"{lift.min():.6g} to {lift.max():.6g} of {stroke:.6g} m"
    if "exergy_closure" in run.scalars:
        enters = sum(run[f"exergy_{name}"] for name in ENTERS)
        if run["exergy_closure"] > EXERGY_CLOSURE and not any("exergy" in line for line in run.warnings):
            yield "exergy does not close, and nothing says so", f"{run['exergy_closure']:.3g}"
        if run["exergy_indicated_work"] > enters * (1.0 + EXERGY_CLOSURE) and run["exergy_indicated_work"] > 0.0:
            yield "more work than exergy", f"{run['exergy_indicated_work']:.6g} of {enters:.6g} J"


def highest_lift(machine, run):
    """Lift that the intake cannot exceed [m]."""
    cam = machine.engine.cam
    if run.conditions.get("intake") == "cam":
        return cam.lift_curve[:, 1].max() if len(cam.lift_curve) else cam.resolve_lift(machine.valve.stroke).lift
    return machine.valve.stroke
