"""The command that identifies parameters from measured data."""

import time
from math import inf

import numpy as np

from apesim.kernel import is_cold
from apesim.quantities import Choice, Culprit, InputError, Quantity, Wrong, parse, quoted, unit
from apesim.quantities.settings import schema
from studies.commands.machine import load_machine
from studies.commands.tables import COMPILING, table_of
from studies.console import COMMAND_LINE, DONE, INCOMPLETE
from studies.identify import Free, identify, predict, run_of
from studies.measured import CHECK, read_measured
from valve.bench import run_bench

METHODS = ("least-squares", "ga")
METHOD = Choice(METHODS, "command line")
PAPER_RANGES = {"valve.viscous_friction": (100.0, 120.0)}
"""Search space of the genetic algorithm: doi 10.1631/jzus.A0820373, Table 2 [N s/m]."""
FLIGHT = 0.1, 0.9
"""Shares of the stroke between which the piston counts as in flight."""
SHIFTS = ("time_shift_s", "noise_limit_s")


def fit_command(console, machine_file, settings, folder, free, method):
    """Parameters from measured data; see `apesim valve fit --help`.

    Parameters
    ----------
    console : studies.console.Console
    machine_file : path or None
    settings : list of str or None
        ``KEY=VALUE``
    folder : path
        Of the measured data.
    free : list of str
        ``KEY`` or ``KEY=LOW:HIGH``
    method : {"least-squares", "ga"} or None

    Returns
    -------
    int
        Exit code.
    """
    machine = load_machine(machine_file, settings)
    method = METHODS[parse(method or METHODS[0], METHOD, where="--method", file=COMMAND_LINE)]
    free = free_parameters(machine, free or (), method)
    measured = read_measured(folder, machine.ambient.pressure)
    if is_cold():
        console.message(COMPILING)
    run_bench(machine, 10e-3)  # compiles, or loads what is compiled
    start = time.perf_counter()
    with console.progress("simulations") as report:
        found = identify(machine, measured, free, method, report)
    checks = [time_shift(found, run) for run in measured.of(CHECK)]
    wall = time.perf_counter() - start
    data = {
        "method": method,
        "parameters": found.parameters,
        "interval_95": found.interval_95,
        "units": {f.key: unit(f.declaration.unit).si_text for f in free},
        "evaluations": found.evaluations,
        "objective": found.objective,
        "objective_unit": "m",
        "correlation": found.correlation,
        "noise": {s: {"deviation": d, "colour": c} for s, (d, c) in found.noise.items()},
        "checks": checks,
        "wall_time_s": wall,
        "warnings": found.warnings,
    }
    console.result(data, *_shown(found, free, checks))
    for warning in found.warnings:
        console.message(f"warning: {warning}")
    return DONE if found.converged else INCOMPLETE


def _shown(found, free, checks):
    """Tables and a line for the terminal."""
    rows = []
    for f in free:
        factor = float(unit(f.declaration.unit).factor)
        values = found.parameters[f.key], *(found.interval_95[f.key] or (None, None))
        texts = ["-" if value is None else f"{value / factor:.6g}" for value in values]
        rows.append((f.key, *texts, f"{f.declaration.unit}{f.declaration.suffix}" or "-"))
    yield table_of("Parameters", ("", "value", "95 % from", "to", "unit"), rows)
    if checks:
        rows = [[check["run"], *(f"{check[key] * 1e3:.4g}" for key in SHIFTS), "ms"] for check in checks]
        header = "run", "largest time shift", "by noise alone, 95 %", "unit"
        yield table_of("Check runs, at equal lift in flight", header, rows)
    yield f"objective {found.objective * 1e3:.5g} mm (Eq. 11); {found.evaluations} simulations"


def free_parameters(machine, texts, method="least-squares"):
    """What ``--free KEY`` and ``--free KEY=LOW:HIGH`` set free.

    Parameters
    ----------
    machine : engine.machine.Machine
    texts : sequence of str
        E.g. ``valve.viscous_friction=100 N s/m:120 N s/m``; without bounds, the declared range of the key holds.
    method : str

    Returns
    -------
    list of Free

    Raises
    ------
    InputError
        With a culprit for each fault.
    """
    leaves = {leaf.key: leaf for leaf in schema(type(machine), machine)}
    found, culprits = [], []
    for text in texts:
        key, given, bounds = (part.strip() for part in text.partition("="))
        try:
            if not isinstance(leaves[key].declaration if key in leaves else None, Quantity):
                raise Wrong(f"{quoted(key)} is no key of a quantity", "give one, e.g. valve.viscous_friction")
            if key in [free.key for free in found]:
                raise Wrong(f"{key} is given twice", "give it once")
            found.append(_free(leaves[key], bounds if given else None, machine.ambient.pressure, method))
        except Wrong as wrong:
            culprits.append(Culprit("command line", "--free", wrong.wrong, wrong.right))
    if not texts:
        culprits.append(Culprit("command line", "--free", "is not given", "write --free valve.viscous_friction"))
    if culprits:
        raise InputError(culprits)
    return found


def _free(leaf, bounds, ambient_pressure, method):
    """One free parameter; raises `Wrong`."""
    key, declaration, value = leaf
    low, high = declaration.ends
    if bounds is not None:
        right = f"write {key}=LOW:HIGH, each with its unit, within {declaration.range_text}"
        ends = bounds.split(":")
        if len(ends) != 2:
            raise Wrong(f"{quoted(bounds)} are no bounds", right)
        try:
            low, high = (declaration.read(end.strip(), ambient_pressure) for end in ends)
        except Wrong as wrong:
            raise Wrong(wrong.wrong, wrong.right or right) from None
        if not low < high < inf:
            raise Wrong(f"{quoted(bounds)}: the first is not below the second", right)
    elif method == "ga" and key in PAPER_RANGES:
        low, high = PAPER_RANGES[key]
    elif not high - low < inf:
        raise Wrong(f"{key} has no range of its own", f"write {key}=LOW:HIGH")
    local = bounds is None and method != "ga" and low < value < high and value != 0.0
    start = value if low < value < high else 0.5 * (low + high)
    scale = abs(value) if local else 0.5 * (high - low)
    return Free(key, declaration, low, high, start, scale, local)


def time_shift(found, run):
    """Largest time shift at equal lift between a measured run and its simulation, while the piston is in flight.

    Parameters
    ----------
    found : studies.identify.Identified
    run : studies.measured.MeasuredRun

    Returns
    -------
    dict
        ``run``; ``time_shift_s``, positive where the measured piston is later; ``noise_limit_s``: what noise alone
        exceeds in one of twenty such runs; NaN where nothing flies or lift is not measured.
    """
    machine = run_of(found.machine, run)
    shifts, noises = [np.empty(0)], [np.empty(0)]
    if "lift" in run.channels:
        deviation, stroke = found.noise.get("lift", (0.0, 0.0))[0], machine.valve.stroke
        times = np.arange(0.0, float(run.times[-1]), 1e-5)
        lift = predict(machine, run._replace(times=times), ("lift",))[0]["lift"]
        for start, end, sign in ((0.0, run.pulse, 1.0), (run.pulse, inf, -1.0)):
            flights = []
            for t, values in ((times, lift), (run.times, run.channels["lift"])):
                within = (t >= start) & (t < end)
                flights += [t[within], (values if sign > 0.0 else stroke - values)[within] / stroke]
            shift, noise = _shifts(*flights, deviation / stroke)
            shifts.append(shift)
            noises.append(noise)
    shift, noise = np.concatenate(shifts), np.concatenate(noises)
    if not len(shift):
        return {"run": run.data, "time_shift_s": np.nan, "noise_limit_s": np.nan}
    return {"run": run.data, "time_shift_s": float(shift[np.argmax(np.abs(shift))]), "noise_limit_s": _largest(noise)}


def _shifts(simulated_times, simulated, times, measured, deviation):
    """Shifts of the samples in flight, and the standard deviation of each; travel and noise as shares of the stroke."""
    none = np.empty(0), np.empty(0)
    if not len(simulated) or not len(measured) or max(simulated[0], measured[0]) > FLIGHT[0]:
        return none
    highest = np.maximum.accumulate(simulated)
    first = np.append(True, np.diff(highest) > 0.0)
    levels, at = highest[first], simulated_times[first]
    if len(levels) < 3:
        return none
    speed = np.maximum(np.gradient(levels, at), 1e-3)
    flying = (measured >= FLIGHT[0]) & (measured <= min(FLIGHT[1], levels[-1]))
    flying[np.argmax(measured) :] = False
    level = measured[flying]
    return times[flying] - np.interp(level, levels, at), deviation / np.interp(level, levels, speed)


def _largest(deviations):
    """What the largest of independent normal deviates of these standard deviations exceeds in one of twenty cases."""
    from scipy.optimize import brentq
    from scipy.special import erf

    widest = deviations.max()
    if widest == 0.0:
        return 0.0
    held = deviations[deviations > 0.0] * np.sqrt(2.0)
    return brentq(lambda x: np.sum(np.log(erf(x / held))) - np.log(0.95), 0.1 * widest, 20.0 * widest)
