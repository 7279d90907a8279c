"""Discharge tests as they are measured: read, checked, and what noise they have.

A test is a CSV with the columns ``time [ms]``, 0 as the valve is switched, and ``pressure [kPa abs]``, in any units;
the pressure says whether it is gauge or absolute. Inside, all is absolute. A folder with a ``measured.toml`` says how
the files of a laboratory are written::

    bench = "discharge"
    [read]
    decimal = ","
    columns = { time = "Zeit (s)", pressure = "Ch1" }
    unit.pressure = "bar abs"
    [[run]]
    data = "p040.csv"
"""

from collections.abc import Iterator, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from apesim.quantities import Fault, InputError, InvalidValue, quoted
from apesim.quantities.files import path_below, require_file
from apesim.studies.measured.columns import TIME, read_columns
from apesim.studies.measured.dialect import READ, Dialect, find_unknown_keys, merge_tables, read_dialect
from apesim.studies.measured.folder_file import (
    find_unknown_start,
    load_folder_file,
    shift_to_start,
    take_read_table,
)
from apesim.studies.measured.plausibility.disturbances import find_disturbances, find_spikes, is_short
from apesim.studies.measured.plausibility.signals import find_noise
from apesim.studies.measured.plausibility.thresholds import MAX_RESOLVED
from apesim.studies.measured.runs import Disturbance
from apesim.studies.measured.sensors import FILE

BENCH = "discharge"
"""What ``bench`` of a folder of discharge tests says."""
PRESSURE = "pressure"
"""Column of the sensor."""
COLUMNS = {TIME: "ms", PRESSURE: "kPa abs"}
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
    notes: tuple[str, ...] = ()
    """What was guessed of its file, or is missing in it, in words."""
    warnings: tuple[str, ...] = ()
    """What was masked, in words."""


def read_test(path: str | PathLike[str], ambient_pressure: float, dialect: Dialect | None = None) -> Record:
    """Read a discharge test: a CSV with the columns ``time`` and ``pressure``, in any units.

    Gauge pressures stand above `ambient_pressure` [Pa abs]; the dialect is guessed if left out. Samples are absolute
    and in SI, without those missing or masked; the InputError for a file that is no discharge test names every fault.
    """
    file, right, dialect = Path(path), 'give a CSV with the header "time [ms],pressure [kPa abs]"', dialect or Dialect()
    table = read_columns(file, COLUMNS, tuple(COLUMNS), ambient_pressure, right=right, dialect=dialect)
    columns, all_faults, notes = table.values, table.faults, table.hints
    warnings: list[str] = []
    if not all_faults:
        all_faults = list(find_unknown_start(str(file), TIME, dialect, is_counted=table.is_counted))
    if not all_faults:
        # Masked before anything is judged: one sample of 0 would be the lowest pressure, and all of the noise.
        columns[TIME] = shift_to_start(columns[TIME], dialect)
        columns[PRESSURE], warnings = _mask(file.name, **columns)
        is_there = ~np.isnan(columns[PRESSURE])
        columns = {name: values[is_there] for name, values in columns.items()}
        all_faults = [Fault(str(file), *fault) for fault in _faults(**columns, ambient_pressure=ambient_pressure)]
    if all_faults:
        raise InputError([_say_where(fault, dialect) for fault in all_faults])
    return Record(file.name, columns[TIME], columns[PRESSURE], tuple(notes), tuple(warnings))


def _say_where(fault: Fault, dialect: Dialect) -> Fault:
    """Fault of a file, with where the table ``[read]`` is that would help it."""
    if dialect.is_stated or "[read]" not in fault.right:
        return fault
    where = f'[read] stands in {FILE} beside bench = "{BENCH}", of a folder that is given in place of the file'
    return fault._replace(right=f"{fault.right}; {where}")


def _mask(file: str, time: np.ndarray, pressure: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Pressures, NaN where a disturbance made them, as in a folder of measured data, and what is said of these.

    The pressure of a vessel only falls: unlike the lift of a valve, it has no true peak of one sample, however coarse.
    """
    masked, said = pressure.copy(), []
    found = list(find_disturbances(time, pressure, TIME))
    if not found and len(time) > 1 and np.median(np.diff(time)) > MAX_RESOLVED[TIME]:
        found = [(Disturbance.SPIKES, find_spikes(pressure, find_noise(pressure)))]
    for disturbance, flags in found:
        if not flags.any():
            continue
        at = np.flatnonzero(flags)
        worst = (
            at[np.argmax(np.abs(pressure[at] - np.nanmedian(pressure)))] if disturbance == Disturbance.SPIKES else at[0]
        )
        place = f"{pressure[worst] / 1e3:.4g} kPa abs in row {worst + 1}, at {1e3 * time[worst]:.4g} ms"
        many = f"{len(at)} samples" if len(at) > 1 else "a sample"
        first = f"{file}: pressure: {disturbance}: {many}, {'the worst' if len(at) > 1 else 'of'} {place}"
        if is_short(time, flags, TIME) or (disturbance == Disturbance.SPIKES and len(at) == 1):
            masked[flags] = np.nan
            said.append(f"{first}; masked: used by nothing")
        else:
            said.append(f"{first}; too many to be masked: they are used; look at sensor and recorder, or write nan")
    return masked, said


def read_tests(files: Sequence[str | PathLike[str]], ambient_pressure: float) -> list[Record]:
    """Read discharge tests: one CSV for each, see `read_test`, or a folder with a ``measured.toml`` that names them.

    Gauge pressures stand above `ambient_pressure` [Pa abs]; the InputError names the faults of all files.
    """
    records, all_faults = [], []
    for given in files:
        try:
            for file, dialect in _tests_of(Path(given)):
                try:
                    records.append(read_test(file, ambient_pressure, dialect))
                except InputError as error:
                    all_faults += error.faults
        except InputError as error:
            all_faults += error.faults
    if all_faults:
        raise InputError(all_faults)
    return records


def _tests_of(given: Path) -> list[tuple[Path, Dialect | None]]:
    """Files of discharge tests, and how each is written, that a folder names; a file is one itself."""
    if given.name != FILE and not given.is_dir():
        return [(given, None)]

    # A folder names its tests. One of another bench is refused alone, as its other keys are not known here.
    path = given if given.name == FILE else given / FILE
    data, file, all_faults = load_folder_file(path), str(path), list[Fault]()
    if data.get("bench") != BENCH:
        wrong = f"{quoted(data['bench'])} is no discharge test" if "bench" in data else "is not given"
        raise InputError([Fault(file, "bench", wrong, f'write bench = "{BENCH}"')])

    # From here on faults are gathered, so that one call names them all.
    all_faults += find_unknown_keys(file, "", data, ("bench", READ, "run"))
    read = take_read_table(file, READ, data, all_faults)
    common, wrong_dialect = read_dialect(file, READ, read, tuple(COLUMNS), is_timed=True)
    all_faults += wrong_dialect
    runs = data.get("run")
    if not isinstance(runs, list) or not runs or not all(isinstance(run, dict) for run in runs):
        all_faults.append(
            Fault(file, "run", "no list of runs", 'give each test a table [[run]] with data = "p040.csv"')
        )
        runs = []

    # The tests, each with its own [read] over that of the folder.
    tests: list[tuple[Path, Dialect | None]] = []
    for number, run in enumerate(runs, 1):
        section = f"run {number}"
        all_faults += find_unknown_keys(file, section, run, ("data", READ))
        dialect = common
        if READ in run:
            at = f"{section}.{READ}"
            merged = merge_tables(read, take_read_table(file, at, run, all_faults))
            dialect, wrong_dialect = read_dialect(file, at, merged, tuple(COLUMNS), is_timed=True)
            all_faults += wrong_dialect
        try:
            tests.append((_file_of(path.parent, run), dialect))
        except InvalidValue as wrong_data:
            all_faults.append(Fault(file, f"{section}.data", wrong_data.wrong, wrong_data.right))
    if all_faults:
        raise InputError(list(dict.fromkeys(all_faults)))
    return tests


def _file_of(folder: Path, run: dict[str, Any]) -> Path:
    """File of a run, in its folder."""
    right, data = 'write data = "p040.csv", its path from the folder', run.get("data")
    if not isinstance(data, str) or not data.strip():
        raise InvalidValue("is not given" if data is None else f"{quoted(data)} is no text", right)
    path = path_below(folder, data)
    require_file(path, right)
    return path


def _faults(time: np.ndarray, pressure: np.ndarray, ambient_pressure: float) -> Iterator[tuple[str, str, str]]:
    """Key, fault and right form of columns that can be no discharge test."""
    before, after = int(np.sum(time <= 0.0)), int(np.sum(time > 0.0))
    if before < MIN_BEFORE or after < MIN_AFTER:
        right = f"give at least {MIN_BEFORE} until t = 0, which tell the noise, and {MIN_AFTER} after it"
        yield "time", f"{before} rows until the valve is switched at t = 0, {after} after it", right
        return
    kilo, start = ambient_pressure / 1e3, pressure[time <= 0.0]
    usual = np.delete(start, np.argmax(np.abs(start - np.median(start))))  # one wrong sample allows no other
    low = ambient_pressure - max(0.03 * ambient_pressure, 6.0 * usual.std())
    if start.mean() < MIN_RATIO**2 * ambient_pressure:
        wrong = f"starts at {start.mean() / 1e3:.4g} kPa abs, not well above the ambient {kilo:.4g} kPa abs"
        yield "pressure", wrong, 'fill the vessel higher; or is it gauge? then write "pressure [kPa gauge]"'
    elif pressure.min() < low:
        row = int(np.argmin(pressure))
        wrong = f"falls to {pressure[row] / 1e3:.4g} kPa abs, below the ambient {kilo:.4g} kPa abs"
        wrong += f", at {1e3 * time[row]:.4g} ms"
        yield "pressure", wrong, 'is it gauge? then write "pressure [kPa gauge]"; else set ambient.pressure'
    elif start.mean() - pressure[-after // 10 :].mean() < max(5.0 * start.std(), 0.02 * (start.mean() - low)):
        yield "pressure", "does not fall after t = 0", "let t = 0 be the switching command, and record the discharge"


def fitted_part(record: Record, ambient_pressure: float) -> Record:
    """Take the samples of a test while it is well above ambient; neighbours are averaged where there are very many.

    They end where the smoothed pressure first falls below `MIN_RATIO` times the ambient one [Pa abs], and are at most
    `MAX_SAMPLES`.

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
    return record._replace(times=times, pressures=pressures)


def min_noise(record: Record) -> float:
    """Find the noise [Pa] below which none is believed: that of the steps between neighbouring values, or of the law.

    It is the smallest difference of two values over the root of 12, but not below 1e-7 of the highest one.

    A sensor with steps of 100 Pa:

    >>> times = np.arange(5) * 1e-3
    >>> round(min_noise(Record("p060", times, np.array([7e5, 7e5, 6.999e5, 6.998e5, 6.995e5]))), 1)
    28.9
    """
    values = np.unique(record.pressures)
    steps = np.diff(values).min() / np.sqrt(12.0) if len(values) > 1 else 0.0
    return float(max(steps, 1e-7 * values[-1]))


def noise_before(record: Record) -> tuple[float, float]:
    """Find standard deviation [Pa] and colour of the noise of a test before the valve is switched at t = 0.

    The deviation is not below `min_noise`; the colour is the correlation of neighbours, 0 where it is not significant.
    """
    before = record.pressures[record.times <= 0.0]
    e = before - before.mean()
    colour = float(e[1:] @ e[:-1] / max(e @ e, 1e-300))
    return max(float(e.std(ddof=1)), min_noise(record)), colour if colour > 2.0 / np.sqrt(len(e)) else 0.0
