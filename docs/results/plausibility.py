"""False alarms and misses of the checks of measured data, on runs of the independent simulator of tests/truth."""

from collections import Counter

import numpy as np

from apesim.studies.measured.plausibility import Kind
from docs.results import Number, Table
from tests.campaigns.honest_data import break_folders, examine_folder, honest, with_effects
from tests.truth.sealed.library import ENGINE, LIBRARY, VALVE

LONG = True
RIGS = {VALVE: 20, ENGINE: 6}
"""Rigs with honest data, each with settings and nuisances of its own."""
SIGMAS = 10.0
"""Size of each effect that is hidden [standard deviations that nuisances do not take on]."""
SENSORS = (
    "lift_sensor_lag",
    "pressure_sensor_lag",
    "sensor_gain",
    "sensor_offset",
    "time_zero",
    "tdc_error",
    "speed_ripple",
)
"""Effects that no physics makes: at the end of its range a slipped sensor is refused, and has to be."""


def compute():
    """Counts of findings on honest data, on data with an effect in them, and on data that were broken."""
    rng = np.random.default_rng(2026)
    rows, faults, runs = [], 0, Counter()
    for bench, number in RIGS.items():
        counted = [examine_folder(*folder) for _ in range(number) for folder in honest(rng, bench)]
        rows.append(row_of(f"{bench}, nothing hidden", counted))
        faults += count(counted, Kind.FAULT)
        runs[bench] = sum(each for _, each in counted)
    for bench in RIGS:
        physics, sensors = ([name for name in LIBRARY if (name in SENSORS) == is_sensor] for is_sensor in (False, True))
        for names, size, what in (
            (physics, SIGMAS, f"each effect of physics at {SIGMAS:g} σ"),
            (physics, None, "each effect of physics at the end of its range"),
            (sensors, SIGMAS, f"each error of a sensor at {SIGMAS:g} σ"),
        ):
            counted = [examine_folder(*folder) for folder in with_effects(rng, bench, names, size)]
            rows.append(row_of(f"{bench}, {what}", counted))
            faults += count(counted, Kind.FAULT)
    broken = [
        [f"{bench}: {what}", Number(sum(judged)), *map(Number, judged)]
        for bench in RIGS
        for what, judged in break_folders(rng, bench)
    ]
    return {
        "honest": Table(["data", "folders", "runs", "faults", "warnings", "hints", "what the warnings say"], rows),
        "broken": Table(
            ["what is wrong", "folders", "refused for it", "refused otherwise", "warned", "silent"], broken
        ),
        "honest_runs": Number(runs[VALVE]),
        "honest_engine_runs": Number(runs[ENGINE]),
        "honest_faults": Number(faults),
        "sigmas": Number(SIGMAS),
    }


def count(counted, kind):
    """Number of findings of a kind."""
    return sum(finding.kind == kind for findings, _ in counted for finding in findings)


def row_of(what, counted):
    """A row of the table of honest data."""
    warnings = Counter(str(one.check) for findings, _ in counted for one in findings if one.kind == Kind.WARNING)
    said = ", ".join(f"{name} ({number})" for name, number in warnings.most_common())
    numbers = [Number(count(counted, kind)) for kind in Kind]
    return [what, Number(len(counted)), Number(sum(runs for _, runs in counted)), *numbers, said or "–"]
