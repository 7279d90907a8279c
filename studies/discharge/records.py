"""Discharge tests as they are measured: read, checked, and what noise they have.

A test is a CSV with the columns ``time [ms]``, 0 as the valve is switched, and ``pressure [kPa abs]``, in any units;
the pressure says whether it is gauge or absolute. Inside, all is absolute.
"""

from collections.abc import Iterator, Sequence
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np

from apesim.quantities import Fault, InputError
from apesim.studies.measured.columns import read_columns

COLUMNS = {"time": "ms", "pressure": "kPa abs"}
"""Columns of a test, and the unit that a message shows for each."""
MIN_BEFORE, MIN_AFTER = 10, 20
"""Samples before and after the switch, at least: the noise is estimated from the first, a fall from the last tenth."""
MAX_SAMPLES = 4000
"""Samples of a test that is fitted: beyond, neighbours are averaged, as the matrices of the fit grow with them."""
MIN_RATIO = 1.1
"""Ratio of the pressure to the ambient one, below which a test tells nothing: an error of its zero weighs too much."""


class Record(NamedTuple):
    """A discharge test."""

    name: str
    times: np.ndarray
    """After the switching command [s], shape (n,), ascending."""
    pressures: np.ndarray
    """[Pa abs], shape (n,)"""


def read_test(path: str | PathLike[str], ambient_pressure: float) -> Record:
    """Read a discharge test.

    Parameters
    ----------
    path : path
        CSV with the columns ``time`` and ``pressure``, in any units.
    ambient_pressure : float
        Pressure that gauge pressures stand above [Pa abs].

    Returns
    -------
    Record
        Samples of the test, absolute and in SI.

    Raises
    ------
    InputError
        The file cannot be read, or is no discharge test; the error names every fault.

    Examples
    --------
    >>> import tempfile
    >>> times = np.arange(-5.0, 20.0, 0.5)
    >>> rows = np.column_stack((times, 100.0 + 600.0 * np.exp(-np.clip(times, 0.0, None) / 12.0)))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     np.savetxt(f"{folder}/p.csv", rows, delimiter=",", header="time [ms],pressure [kPa abs]", comments="")
    ...     record = read_test(f"{folder}/p.csv", 100e3)
    >>> record.name, len(record.times), float(record.pressures[0])
    ('p.csv', 50, 700000.0)
    """
    file, right = Path(path), 'give a CSV with the header "time [ms],pressure [kPa abs]"'
    columns, _, all_faults, _ = read_columns(
        file, COLUMNS, tuple(COLUMNS), ambient_pressure, right=right, allow_missing=False
    )
    if not all_faults:
        all_faults = [Fault(str(file), *fault) for fault in _faults(**columns, ambient_pressure=ambient_pressure)]
    if all_faults:
        raise InputError(all_faults)
    return Record(file.name, columns["time"], columns["pressure"])


def read_tests(files: Sequence[str | PathLike[str]], ambient_pressure: float) -> list[Record]:
    """Read discharge tests.

    Parameters
    ----------
    files : sequence of path
        One CSV for each test, see `read_test`.
    ambient_pressure : float
        Pressure that gauge pressures stand above [Pa abs].

    Returns
    -------
    list of Record
        Tests in the order of the files.

    Raises
    ------
    InputError
        A file cannot be used; the error names the faults of all files.

    Examples
    --------
    >>> try:
    ...     read_tests(["p040.csv", "p060.csv"], 100e3)
    ... except InputError as error:
    ...     print(len(error.faults), "faults")
    2 faults
    """
    records, all_faults = [], []
    for file in files:
        try:
            records.append(read_test(file, ambient_pressure))
        except InputError as error:
            all_faults += error.faults
    if all_faults:
        raise InputError(all_faults)
    return records


def _faults(time: np.ndarray, pressure: np.ndarray, ambient_pressure: float) -> Iterator[tuple[str, str, str]]:
    """Key, fault and right form of columns that can be no discharge test."""
    before, after = int(np.sum(time <= 0.0)), int(np.sum(time > 0.0))
    if before < MIN_BEFORE or after < MIN_AFTER:
        right = f"give at least {MIN_BEFORE} until t = 0, which tell the noise, and {MIN_AFTER} after it"
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


def fitted_part(record: Record, ambient_pressure: float) -> Record:
    """Take the samples of a test while it is well above ambient; neighbours are averaged where there are very many.

    Parameters
    ----------
    record : Record
        Test as it was measured.
    ambient_pressure : float
        Pressure that the vessel empties into [Pa abs].

    Returns
    -------
    Record
        Samples until the smoothed pressure first falls below `MIN_RATIO` times the ambient one, at most `MAX_SAMPLES`.

    Examples
    --------
    >>> times = np.arange(-1e-3, 60e-3, 1e-4)
    >>> pressures = 1e5 + 6e5 * np.exp(-np.clip(times, 0.0, None) / 12e-3)
    >>> part = fitted_part(Record("p060", times, pressures), 1e5)
    >>> round(float(part.pressures[-1]), -3)
    110000.0
    """
    width = max(5, len(record.times) // 200)
    smooth = np.convolve(np.pad(record.pressures, width // 2, mode="edge"), np.ones(width) / width, mode="valid")
    low = (smooth[: len(record.times)] < MIN_RATIO * ambient_pressure) & (record.times > 0.0)
    end = int(np.argmax(low)) if low.any() else len(low)
    group = -(-end // MAX_SAMPLES)
    whole = end // group * group
    times, pressures = (column[:whole].reshape(-1, group).mean(axis=1) for column in (record.times, record.pressures))
    return Record(record.name, times, pressures)


def min_noise(record: Record) -> float:
    """Find the noise below which none is believed: that of the steps between neighbouring values, or of the law.

    Parameters
    ----------
    record : Record
        Test as it was measured.

    Returns
    -------
    float
        Smallest difference of two values over the root of 12, but not below 1e-7 of the highest one [Pa].

    Examples
    --------
    A sensor with steps of 100 Pa:

    >>> times = np.arange(5) * 1e-3
    >>> round(min_noise(Record("p060", times, np.array([7e5, 7e5, 6.999e5, 6.998e5, 6.995e5]))), 1)
    28.9
    """
    values = np.unique(record.pressures)
    steps = np.diff(values).min() / np.sqrt(12.0) if len(values) > 1 else 0.0
    return float(max(steps, 1e-7 * values[-1]))


def noise_before(record: Record) -> tuple[float, float]:
    """Find the noise of a test before the valve is switched.

    Parameters
    ----------
    record : Record
        Test with samples until t = 0.

    Returns
    -------
    deviation : float
        Standard deviation, not below `min_noise` [Pa].
    colour : float
        Correlation of neighbours; 0 where it is not significant [-].

    Examples
    --------
    >>> times = np.linspace(-20e-3, 0.0, 400)
    >>> pressures = 7e5 + 500.0 * np.random.default_rng(0).standard_normal(400)
    >>> deviation, colour = noise_before(Record("p060", times, pressures))
    >>> round(deviation, -2), colour
    (500.0, 0.0)
    """
    before = record.pressures[record.times <= 0.0]
    e = before - before.mean()
    colour = float(e[1:] @ e[:-1] / max(e @ e, 1e-300))
    return max(float(e.std(ddof=1)), min_noise(record)), colour if colour > 2.0 / np.sqrt(len(e)) else 0.0
