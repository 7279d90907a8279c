"""The comparison of valves over speed, as an archive."""

from math import nan

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.columns import column, run_axis, run_text, values_of
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.indicators import COUNTS, INDICATORS
from apesim.kernel import sources_hash
from apesim.quantities.settings import dumps
from apesim.studies.assessment.causes import CAUSES, EXERGY, LATENESS, LOSSES, MEASURES, ORDERS, REAL, VALVES, losses
from apesim.studies.assessment.valves import CYCLES, OUTCOMES, Outcome, assess, without_valves
from apesim.studies.timing.solve import corrected, start_after

TIMINGS = (FIXED, CORRECTED) = ("fixed", "corrected")


def commanded(machine, speeds, timing):
    """The machine at each speed: with its own commands, or with those that make the real valve meet its targets.

    Yields
    ------
    apesim.engine.machine.Machine or None
        None where the targets are out of reach.
    """
    before = []
    for speed in speeds:
        if timing == FIXED:
            yield machine
            continue
        found = corrected(machine, speed, start_after(machine, speed, before))
        if found.reachable:
            before.append((speed, found))
        yield found.machine if found.reachable else None


def assess_speeds(machine, speeds, timing=FIXED, command="", report=None):
    """The valves that are compared, and what each cause costs, over speed.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    speeds : sequence of float
        [rad/s]
    timing : str
        Of `TIMINGS`.
    command : str
        The command line, for the archive.
    report : function, optional
        Called with the numbers of points done and in all.

    Returns
    -------
    Archive
        A run for each speed.
    """
    found = []
    for speed, one in zip(speeds, commanded(machine, speeds, timing), strict=True):
        found.append(assess(one, speed) if one else without_valves(speed, nan, nan, Outcome.OUT_OF_REACH))
        if report:
            report(len(found), len(speeds))
    valves = np.stack([point.valves for point in found])
    lost = losses(valves)

    variables = {
        "run": run_axis(len(found)),
        "valve": Variable(("valve",), np.array(list(VALVES)), "1", _listed(VALVES)),
        "order": Variable(("order",), np.array(list(ORDERS)), "1", _listed(ORDERS)),
        "cause": Variable(("cause",), np.array(list(CAUSES)), "1", _listed(CAUSES)),
        "speed_rpm": column(
            [float(f"{s / TURN * 60.0:.12g}") for s in speeds], *INDICATORS["speed_rpm"], coordinate=True
        ),
        "energise_deg": column(
            [point.energise / DEGREE for point in found], "deg", "crank angle at which the solenoids are energised"
        ),
        "release_deg": column([point.release / DEGREE for point in found], "deg", "crank angle of the release"),
        "outcome": column([point.outcome for point in found], "1", "whether all valves could be compared", OUTCOMES),
    }
    for number, (name, (unit, description)) in enumerate(MEASURES.items()):
        variables[name] = Variable(("run", "valve"), valves[..., number].copy(), unit, f"{description} with each valve")
        lost_name, sign = list(LOSSES.items())[number]
        what = f"{description} {'lost' if sign < 0.0 else 'added'} by each cause in each order"
        variables[lost_name] = Variable(("run", "order", "cause"), lost[..., number].copy(), unit, what)
    exergy = np.stack([point.exergy for point in found])
    for number, (name, (description, _)) in enumerate(EXERGY.items()):
        values = exergy[..., number].copy()
        variables[f"exergy_{name}_J"] = Variable(("run", "valve"), values, "J", f"{description}, in a cycle")
    for name in REAL:
        unit, description = INDICATORS[name]
        kind = np.int64 if name in COUNTS else float
        values = np.array([point.real[name] for point in found], dtype=kind)
        variables[name] = column(values, unit, f"{description}; of the real valve")
    for stroke in ("opening", "closing"):
        for name, (unit, description) in LATENESS.items():
            values = [point.lateness[f"{stroke}_{name}"] for point in found]
            variables[f"{stroke}_{name}"] = column(values, unit, f"{stroke} of the real valve: {description}")
    variables["cycle_to_cycle_torque_Nm"] = column(
        [point.cycle_to_cycle for point in found],
        "N m",
        f"largest change of the real valve's indicated torque from a cycle to the next, of {CYCLES}",
    )
    return Archive(dumps(machine), {"command": command, "kernels": sources_hash(), "timing": timing}, variables)


def _listed(meanings):
    return ", ".join(f"{name}: {meaning}" for name, meaning in meanings.items())


def faults_of_assessment(archive):
    """One line for each point at which not all valves could be compared.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    list of str
    """
    v, lines = values_of(archive), []
    for run, (outcome, change) in enumerate(zip(v["outcome"], v["cycle_to_cycle_torque_Nm"], strict=True)):
        if outcome != Outcome.COMPLETE:
            line = f"{run_text(archive, run)}: {Outcome(outcome).remedy}"
            changes = f"; its indicated torque changes by up to {change:.3g} N m from a cycle to the next"
            lines.append(line + (changes if outcome == Outcome.NOT_PERIODIC else ""))
    return lines


def undefined_ratios(archive):
    """Lines that say where valves do no work, so that their air over work is undefined.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    list of str
    """
    v = values_of(archive)
    speeds = {}
    for work in ("indicated", "brake"):
        for torques, speed in zip(v[f"{work}_torque_Nm"], v["speed_rpm"], strict=True):
            idle = ", ".join(name for name, torque in zip(VALVES, torques, strict=True) if torque <= 0.0)
            if idle:
                speeds.setdefault((work, idle), []).append(f"{speed:g}")
    return [
        f"{work} work of {idle} is not positive at {', '.join(found)} r/min: air over it is null"
        for (work, idle), found in speeds.items()
    ]
