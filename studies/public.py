"""The computing functions of the public face: a call is refused for what a file or a command would be refused for.

What computes many runs in one go (sweeps, fits) calls the functions behind these, and is checked once.
"""

import functools
import inspect
from typing import Any

import numpy as np

from apesim.engine import indicators as engine_indicators
from apesim.engine import steady
from apesim.engine.angles import TURN
from apesim.engine.cylinder import INTAKES
from apesim.engine.machine import Machine
from apesim.quantities import Choice, Culprit, InputError, Pressure, Quantity, Wrong, quoted
from apesim.quantities.checking import check
from apesim.studies import sweep
from apesim.studies.operating_conditions import SPEED, TIME
from apesim.studies.sweep.plan import TIMING_NAMES
from apesim.valve import bench

CALL = "a call"
SHARE = Quantity("", 1e-14, 1e-2, CALL)
"""A tolerance: finer, rounding decides; coarser, it is no solution."""
ANGLE_STEP = Quantity("deg", 1e-3, 360, CALL)
TRACE_ANGLE = Quantity("deg", -720, 1080, CALL)
SAMPLE = Quantity("ms", 1e-4, 60000, CALL)
INSTANT = Quantity("ms", 0, 60000, CALL)
PERIOD = Quantity("ms", 1, float("inf"), CALL)
BEFORE_GROOVE = Pressure(0.001, 30, CALL)
COUNT = Quantity("", 1, 100_000, CALL, whole=True)


def checked(function, faults=None, **declarations):
    """A function whose machine and numbers are checked before it is called.

    Parameters
    ----------
    function : function
        What it calls ``machine`` is an `apesim.engine.machine.Machine`.
    faults : function, optional
        Of the arguments by name: yields (name, what is wrong, what would be right) where only several show it.
    **declarations : Declaration or list
        Of its arguments in SI; a list of one declaration is that of a sequence, of one number at least.

    Returns
    -------
    function
        Raises `InputError` with every fault.
    """
    signature = inspect.signature(function)

    @functools.wraps(function)
    def call(*arguments, **options):
        bound = signature.bind(*arguments, **options)
        bound.apply_defaults()
        given, culprits = bound.arguments, []
        where = f"{function.__name__}()"
        if "machine" in given:
            try:
                check(given["machine"], machine_class_of(given["machine"]), where)
            except InputError as error:
                culprits += error.culprits
        for name, declaration in declarations.items():
            if given[name] is not None or signature.parameters[name].default is not None:
                try:
                    given[name] = _number(given[name], declaration)
                except Wrong as wrong:
                    culprits.append(Culprit(where, name, wrong.wrong, wrong.right))
        if faults and not culprits:
            culprits = [Culprit(where, *fault) for fault in faults(given)]
        if culprits:
            raise InputError(culprits)
        return function(*bound.args, **bound.kwargs)

    return call


def _number(value, declaration):
    """A number as the kernels are compiled for it, or a sequence as it is; raises `Wrong`."""
    if not isinstance(declaration, list):
        declaration.check(value)
        return value if isinstance(declaration, Choice) else int(value) if declaration.whole else float(value)
    if np.ndim(value) != 1 or not len(value):
        raise Wrong(f"{quoted(value)} is no list", "give a list, of one at least")
    for one in value:
        declaration[0].check(one)
    return value


def machine_class_of(machine: Any) -> type[Machine]:
    """The class that a machine has to be of: with effects from outside its own."""
    return type(machine) if isinstance(machine, Machine) else Machine


def _falls(values):
    return np.any(np.diff(values) < 0.0)


def _steady_faults(given):
    angles, start = given["angles"], given["machine"].command.energise
    if angles is not None and (_falls(angles) or angles[0] < start or angles[-1] > start + TURN * (1.0 + 1e-12)):
        yield "angles", "do not rise within the turn from the energising on", "sort them, modulo a turn"


def _bench_faults(given):
    pulse, period, until, sample = (given[name] for name in ("pulse", "period", "until", "sample"))
    if pulse >= period:
        yield "pulse", "is longer than the period", f"less than {period:g} s"
    if until is not None and period < float("inf"):
        yield "until", "does not go with a period", "leave one of them out"
    try:
        _number(sample, [INSTANT] if np.ndim(sample) else SAMPLE)
    except Wrong as wrong:
        yield "sample", wrong.wrong, wrong.right
    else:
        if np.ndim(sample) and _falls(sample):
            yield "sample", "do not rise", "sort the times"
    for name in ("brakes", "brakes_b"):
        edges = () if given[name] is None else given[name]
        try:
            _number([0.0, *edges], [INSTANT])
        except Wrong as wrong:
            yield name, wrong.wrong, wrong.right
            continue
        within = sum(edge < pulse for edge in edges)
        if within % 2:
            yield name, f"{within} edges within the pulse", "an even number of them: off and on again"


def _sweep_faults(given):
    for machine in given["variation"].machines if given["variation"] else ():
        try:
            check(machine, machine_class_of(machine), "")
        except InputError as error:
            yield from ((f"variation: {wrong.key}", *wrong[2:]) for wrong in error.culprits)
            return


run_steady = checked(
    steady.run_steady,
    _steady_faults,
    speed=SPEED,
    tolerance=SHARE,
    angle_step=ANGLE_STEP,
    max_cycles=COUNT,
    periodic_tolerance=SHARE,
    trace_start=TRACE_ANGLE,
    angles=[TRACE_ANGLE],
)
run_bench = checked(
    bench.run_bench,
    _bench_faults,
    pulse=TIME,
    until=TIME,
    period=PERIOD,
    tolerance=SHARE,
    intake_pressure=BEFORE_GROOVE,
)
indicators = checked(engine_indicators.indicators)
run_sweep = checked(
    sweep.run_sweep,
    _sweep_faults,
    speeds=[SPEED],
    intakes=[Choice(INTAKES, CALL)],
    timings=[Choice(TIMING_NAMES, CALL)],
    jobs=COUNT,
)
