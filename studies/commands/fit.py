"""The command that identifies parameters from measured data."""

import time
from math import inf, isnan

from apesim.quantities import Choice, Culprit, InputError, Quantity, Wrong, parse, quoted, unit
from apesim.quantities.settings import schema
from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.identify import Free, identify, judge
from apesim.studies.measured import CHECK, GATE, VALVE, read_measured
from apesim.studies.tables import table_of
from apesim.valve.bench import run_bench
from apesim.valve.effects import ValveEffects

METHODS = ("least-squares", "ga")
METHOD = Choice(METHODS, "command line")
PAPER_RANGES = {"valve.viscous_friction": (100.0, 120.0)}
"""Search space of the genetic algorithm: doi 10.1631/jzus.A0820373, Table 2 [N s/m]."""
BENCH = ("air", "ambient", "supply", "valve")
"""Sections of the machine that the valve's bench is made of, besides its effects."""
HEADER = ("run", "largest time shift [ms]", "by noise alone, 95 % [ms]", "left over noise", "limit")


def fit_command(common, *, folder, free, method):
    """Parameters from measured data; see `apesim valve fit --help`.

    Parameters
    ----------
    common : apesim.studies.options.Common
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
    console, machine = common.console, common.load_machine()
    method = METHODS[parse(method or METHODS[0], METHOD, where="--method", file=COMMAND_LINE)]
    free = free_parameters(machine, free or (), method)
    measured = read_measured(folder, machine.ambient.pressure, VALVE)
    console.warm_up(run_bench, machine, 10e-3)
    start = time.perf_counter()
    with console.progress("simulations") as report:
        found = call_in_thread(identify, machine, measured, free, method, report).result()
    judged = {role: judge(found, measured, free, measured.of(role)) for role in (GATE, CHECK)}
    wall = time.perf_counter() - start
    for one in judged[GATE]:
        if isnan(one.residual_over_noise):
            found.warnings.append(f"{one.run}: a gate without lift or chamber pressures judges nothing")
    data = {
        "method": method,
        "parameters": found.parameters,
        "interval_95": found.interval_95,
        "units": {f.key: si_unit(f.declaration) for f in free},
        "evaluations": found.evaluations,
        "objective": found.objective,
        "objective_unit": "m",
        "correlation": found.correlation,
        "noise": {s: {"deviation": d, "colour": c} for s, (d, c) in found.noise.items()},
        "gates": [one._asdict() for one in judged[GATE]],
        "checks": [one._asdict() for one in judged[CHECK]],
        "refused": any(one.contradicted for one in judged[GATE]),
        "wall_time_s": wall,
        "warnings": found.warnings,
    }
    console.result(data, *_shown(found, free, judged))
    for warning in found.warnings:
        console.message(f"warning: {warning}")
    refused = [one for one in judged[GATE] if one.contradicted]
    for one in refused:
        console.message(
            f"{one.run}: refuses the model: what is left is {one.residual_over_noise:.3g} times the noise, "
            f"beyond the {one.limit:.3g} that noise and the parameters' uncertainty allow"
        )
    return DONE if found.converged and not refused else INCOMPLETE


def si_unit(declaration):
    """Name of the SI unit of a quantity: the declared one if it is that, e.g. "N s/m"."""
    own = unit(declaration.unit)
    si = own._replace(factor=1, offset=0)
    names = [name for name in (declaration.unit, "Pa") if unit(name) == si]
    return f"{names[0] or '-'}{declaration.suffix}" if names else own.si_text


def _shown(found, free, judged):
    """Tables and a line for the terminal."""
    rows = []
    for f in free:
        factor = float(unit(f.declaration.unit).factor)
        values = found.parameters[f.key], *(found.interval_95[f.key] or (None, None))
        texts = ["-" if value is None else f"{value / factor:.6g}" for value in values]
        rows.append((f.key, *texts, f"{f.declaration.unit}{f.declaration.suffix}" or "-"))
    yield table_of("Parameters", ("", "value", "95 % from", "to", "unit"), rows)
    for role, runs in judged.items():
        if runs:
            rows = [
                (
                    one.run,
                    f"{one.time_shift_s * 1e3:.4g}",
                    f"{one.noise_limit_s * 1e3:.4g}",
                    f"{one.residual_over_noise:.3g}",
                    f"{one.limit:.3g}",
                )
                for one in runs
            ]
            yield table_of(f"{role.capitalize()} runs, not fitted", HEADER, rows)
    yield f"objective {found.objective * 1e3:.5g} mm (Eq. 11); {found.evaluations} simulations"


def free_parameters(machine, texts, method="least-squares"):
    """What ``--free KEY`` and ``--free KEY=LOW:HIGH`` set free.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
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
            if not _on_bench(key):
                right = "free a key of the valve, its effects, the supply, the ambient or the air"
                raise Wrong(f"{key} has no part in the valve's bench", right)
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


def _on_bench(key):
    """Whether a key of the machine has a part in a run of the valve's bench."""
    section, name, *_ = key.split(".")
    return section in BENCH or (section == "effects" and name in ValveEffects._fields)


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
