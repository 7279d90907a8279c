"""Discharge tests as they are measured: read, checked, and what noise they have.

A test is a CSV with the columns ``time [ms]``, 0 as the valve is switched, and ``pressure [kPa abs]``, in any units;
the pressure says whether it is gauge or absolute. Inside, all is absolute.
"""

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np

from apesim.quantities import Fault, InputError
from apesim.studies.measured.columns import read_columns

COLUMNS = {"time": "ms", "pressure": "kPa abs"}
FEWEST_BEFORE, FEWEST_AFTER = 10, 20
MAX_SAMPLES = 4000
MIN_RATIO = 1.1
"""Ratio of the pressure to the ambient one, below which a test tells nothing: an error of its zero weighs too much."""


class Record(NamedTuple):
    """A discharge test."""

    name: str
    times: np.ndarray
    """After the switching command [s], shape (n,), ascending."""
    pressures: np.ndarray
    """[Pa abs], shape (n,)"""


def read_test(path, ambient_pressure):
    """Read a discharge test.

    Parameters
    ----------
    path : path
    ambient_pressure : float
        What gauge pressures stand above [Pa].

    Returns
    -------
    Record

    Raises
    ------
    InputError
        With every fault.
    """
    path, right = Path(path), 'give a CSV with the header "time [ms],pressure [kPa abs]"'
    columns, _, all_faults = read_columns(path, COLUMNS, tuple(COLUMNS), ambient_pressure, right)
    if not all_faults:
        all_faults = [Fault(str(path), *fault) for fault in _faults(**columns, ambient_pressure=ambient_pressure)]
    if all_faults:
        raise InputError(all_faults)
    return Record(path.name, columns["time"], columns["pressure"])


def read_tests(files: Sequence[str | PathLike[str]], ambient_pressure: float) -> list[Record]:
    """Read the records of discharge tests; raise `InputError` with the all_faults of all files."""
    records, all_faults = [], []
    for file in files:
        try:
            records.append(read_test(file, ambient_pressure))
        except InputError as error:
            all_faults += error.faults
    if all_faults:
        raise InputError(all_faults)
    return records


def _faults(time, pressure, ambient_pressure):
    """Key, fault and right form of columns that can be no discharge test."""
    before, after = int(np.sum(time <= 0.0)), int(np.sum(time > 0.0))
    if before < FEWEST_BEFORE or after < FEWEST_AFTER:
        right = f"give at least {FEWEST_BEFORE} until t = 0, which tell the noise, and {FEWEST_AFTER} after it"
        yield "time", f"{before} rows until the valve is switched at t = 0, {after} after it", right
        return
    kilo, start = ambient_pressure / 1e3, pressure[time <= 0.0]
    low = ambient_pressure - max(0.03 * ambient_pressure, 6.0 * start.std())
    if start.mean() < MIN_RATIO**2 * ambient_pressure:
        wrong = f"starts at {start.mean() / 1e3:.4g} kPa abs, not well above the ambient {kilo:.4g} kPa abs"
        yield "pressure", wrong, 'fill the vessel higher; or is it gauge? then write "pressure [kPa gauge]"'
    elif pressure.min() < low:
        wrong = f"falls to {pressure.min() / 1e3:.4g} kPa abs, below the ambient {kilo:.4g} kPa abs"
        yield "pressure", wrong, 'is it gauge? then write "pressure [kPa gauge]"; else set ambient.pressure'
    elif start.mean() - pressure[-after // 10 :].mean() < max(5.0 * start.std(), 0.02 * (start.mean() - low)):
        yield "pressure", "does not fall after t = 0", "let t = 0 be the switching command, and record the discharge"


def fitted_part(record, ambient_pressure):
    """The samples of a test while it is well above ambient, neighbours averaged where there are very many."""
    width = max(5, len(record.times) // 200)
    smooth = np.convolve(np.pad(record.pressures, width // 2, mode="edge"), np.ones(width) / width, mode="valid")
    low = (smooth[: len(record.times)] < MIN_RATIO * ambient_pressure) & (record.times > 0.0)
    end = int(np.argmax(low)) if low.any() else len(low)
    group = -(-end // MAX_SAMPLES)
    whole = end // group * group
    averaged = (column[:whole].reshape(-1, group).mean(axis=1) for column in record[1:])
    return Record(record.name, *averaged)


def min_noise(record):
    """Below which no noise is believed: that of the steps between neighbouring values, or of the law [Pa]."""
    values = np.unique(record.pressures)
    steps = np.diff(values).min() / np.sqrt(12.0) if len(values) > 1 else 0.0
    return max(steps, 1e-7 * values[-1])


def noise_before(record):
    """Standard deviation [Pa] and colour (lag-one correlation where it is significant) before the valve is switched."""
    before = record.pressures[record.times <= 0.0]
    e = before - before.mean()
    colour = float(e[1:] @ e[:-1] / max(e @ e, 1e-300))
    return max(e.std(ddof=1), min_noise(record)), colour if colour > 2.0 / np.sqrt(len(e)) else 0.0
