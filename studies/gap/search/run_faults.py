"""Faults of measurement of one file, as candidates beside the effects of the library.

What is so in one run alone is no physics. A sensor that slipped between two runs, a trigger that came late once, a
supply that was noted wrong or two swapped channels are fitted to the file that they are in, and never named as an
effect.
"""

from collections.abc import Iterable, Iterator, Sequence
from enum import StrEnum
from math import isnan

from apesim.studies.estimation.parameters import Parameter
from apesim.studies.gap.search.candidates import Candidate
from apesim.studies.measured import CYLINDER, FIT, VALVE, Measured, MeasuredRun
from apesim.studies.measured.prediction import MEANS
from apesim.valve.effects.channel_swap import SWAPPED

MIN_FILES = 3
"""Files that are fitted, from which on faults of one are looked for: of two that differ, none is the odd one."""


class FaultKind(StrEnum):
    """What may be wrong with the record of one run."""

    OFFSET = "run_offset"
    """The zero of a channel."""
    GAIN = "run_gain"
    """The scale of a channel."""
    CLOCK = "run_clock"
    """The rate of the recorder."""
    TIME_ZERO = "run_time_zero"
    """The trigger."""
    SUPPLY = "run_supply"
    """The supply's pressure that the run states."""
    TEMPERATURE = "run_temperature"
    """The supply's temperature that the run states."""
    SWAP = "run_swap"
    """The names of both chambers' pressures."""
    ANGLE = "run_angle"
    """The zero of an engine's crank angle."""


OFFSETS = {
    "lift": 0.5e-3,
    "pressure_a": 20e3,
    "pressure_b": 20e3,
    "cylinder_pressure": 20e3,
    "torque": 2.0,
    "air_flow": 2e-3,
    "force": 5.0,
}
"""Size of an offset that a search begins with, by channel [SI]."""
GAIN, CLOCK, SUPPLY = 0.1, 0.02, 0.1
"""Sizes of shares that a search begins with."""
TIME_ZERO, TEMPERATURE, ANGLE = 2e-3, 20.0, 0.035
"""Sizes of a time [s], a temperature [K] and an angle [rad] that a search begins with."""
MAX_SIZES = 10.0
"""Sizes beyond which no fault is fitted: what is farther off does not pass the checks before any fit."""
MAX_SHARE = 5.0
"""Sizes of a share beyond which no fault is fitted: a supply may be noted 50 % too high."""


def find_run_faults(measured: Measured) -> list[Candidate]:
    """The faults that each file to be fitted may have, file after file.

    There are none where fewer than `MIN_FILES` are fitted.
    """
    by_file = {run.file: run for run in measured.of(FIT)}
    if len(by_file) < MIN_FILES:
        return []
    return [fault for run in by_file.values() for fault in list_faults(run)]


def list_faults(run: MeasuredRun) -> Iterator[Candidate]:
    """The faults that the record of one run may have."""
    for sensor in (*run.channels, *run.means):
        if sensor not in OFFSETS:
            continue
        yield make_fault(run, FaultKind.OFFSET, f"effects.sensor_offset.{sensor}", OFFSETS[sensor], sensor=sensor)
        if sensor not in MEANS:
            key = f"effects.sensor_gain.{sensor}"
            yield make_fault(run, FaultKind.GAIN, key, GAIN, farthest=MAX_SHARE, sensor=sensor)
    if run.bench == CYLINDER:
        return
    if run.bench == VALVE:
        yield make_fault(run, FaultKind.TIME_ZERO, "effects.time_zero.time", TIME_ZERO)
        yield make_fault(run, FaultKind.CLOCK, "effects.clock_error.share", CLOCK, farthest=MAX_SHARE)
    elif run.channels:
        yield make_fault(run, FaultKind.ANGLE, "effects.tdc_error.angle", ANGLE)
    if set(SWAPPED) <= set(run.channels):
        yield make_fault(run, FaultKind.SWAP, "effects.channel_swap.share", 1.0, ends=(0.0, 1.0))
    yield make_fault(run, FaultKind.SUPPLY, "supply.pressure", SUPPLY, farthest=MAX_SHARE, relative=True)
    if not isnan(run.temperature):
        yield make_fault(run, FaultKind.TEMPERATURE, "supply.temperature", TEMPERATURE, farthest=MAX_SHARE)


def make_fault(
    run: MeasuredRun,
    kind: FaultKind,
    key: str,
    size: float,
    *,
    farthest: float = MAX_SIZES,
    ends: tuple[float, float] | None = None,
    relative: bool = False,
    sensor: str = "",
) -> Candidate:
    """A fault of one file as a candidate: one number of the machine that is another for this run alone.

    The machine's `key` changes by `size` [SI] at x = 1, by a share of what the run states where `relative`. x lies
    within `ends`, by default from ``-farthest`` to ``farthest``; `sensor` names the channel, where the fault is in one.
    """
    low, high = ends or (-farthest, farthest)
    name = f"{kind}{f' of {sensor}' if sensor else ''} in {run.file}"
    strength = Parameter(key, size, low, high, shifts=True, relative=relative, file=run.file)
    return Candidate(name, (strength,), (), run.file, kind)


def find_files(candidates: Iterable[Candidate]) -> list[str]:
    """The files that faults are in, each once; effects of the library among `candidates` count for no file."""
    return list(dict.fromkeys(candidate.file for candidate in candidates if candidate.file))


def leave_out(measured: Measured, files: Sequence[str]) -> Measured:
    """Measured data without the runs of some files, which are named as in `MeasuredRun.file`."""
    return measured._replace(runs=tuple(run for run in measured.runs if run.file not in files))
