"""A folder of measured data, read strictly.

All that is wrong is reported at once, each fault with its file, its key or column, and the right form.
"""

from collections.abc import Iterator, Mapping
from math import nan
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from apesim.air import Ambient
from apesim.engine.command import window_fault
from apesim.engine.machine import Machine
from apesim.engine.stated_uncertainties import KNOWN_TO
from apesim.quantities import Arguments, Fault, InputError, InvalidValue, make_fault, quoted
from apesim.quantities.arguments import Given
from apesim.quantities.files import path_below, require_file
from apesim.quantities.trees import fields
from apesim.studies.execution.calls import public
from apesim.studies.measured.columns import TIME, read_columns
from apesim.studies.measured.dialect import READ, Dialect, ReadTable, find_unknown_keys, merge_tables, read_dialect
from apesim.studies.measured.folder_file import (
    find_unknown_start,
    load_folder_file,
    shift_to_start,
    take_read_table,
)
from apesim.studies.measured.plausibility.disturbances import (
    find_code_limits,
    find_impossible,
    is_short,
    mask_disturbances,
)
from apesim.studies.measured.plausibility.thresholds import MAX_MASKED
from apesim.studies.measured.runs import (
    BENCHES,
    CYLINDER,
    ENGINE,
    NO_ANGLES,
    ROLES,
    VALVE,
    Bench,
    Disturbance,
    Masked,
    Measured,
    MeasuredRun,
)
from apesim.studies.measured.scatter import SCATTER, read_scatter
from apesim.studies.measured.sensors import ANGLE, EXAMPLES, FILE, SENSORS, Sensors
from apesim.studies.measured.stated_uncertainties import find_absent_sensors, read_table
from apesim.studies.measured.strokes import split_record
from apesim.studies.measured.thinning import thin

STANDARD_AMBIENT = Machine().ambient.pressure
"""Pressure that gauge pressures stand above in the default machine [Pa abs]."""
TOP_KEYS = ("bench", "sensor", KNOWN_TO, SCATTER, "run", "read")
"""Keys at the top of the file."""
TEXT_KEYS = ("data", "name")
"""Keys of a run that are texts."""
MAX_RUNS = 1000
"""Runs of a folder: reading takes some 20 ms of each, judging and fitting more; a laboratory's day has some hundred."""
MIN_ROWS = 8
"""Rows of a record: with fewer no noise can be estimated."""
MAX_VELOCITY = 100.0
"""Velocity that no valve has [m/s]: such a sample says nothing of a sign."""
MAX_TURNED = -0.5
"""Correlation of the lift with the integral of the velocity, below which the sign is the wrong one: of an ideal pair it
is 1, or -1 if turned; noise and drifts only bring it nearer to 0."""


class _Gathered:
    """What is said of the files of a folder, gathered run by run."""

    def __init__(self) -> None:
        self.faults: list[Fault] = []
        self.hints: list[str] = []
        self.masked: list[Masked] = []
        self.tables: dict[str, ReadTable] = {}


@public
def read_measured(
    folder: str | PathLike[str], ambient_pressure: Given = STANDARD_AMBIENT, bench: str | None = None
) -> Measured:
    """Read a folder of measured data.

    Parameters
    ----------
    folder : path
    ambient_pressure : str, (float, str) or float
        Pressure that gauge pressures stand above [Pa abs]; the default machine's if left out.
    bench : {"valve", "engine", "cylinder"}, optional
        The only one that is of use.

    Returns
    -------
    Measured

    Raises
    ------
    InputError
        It names each fault; where the bench is of no use, that alone.

    Examples
    --------
    What ``apesim valve run --csv`` writes is measured data, too:

    >>> import tempfile
    >>> from pathlib import Path
    >>> import apesim
    >>> run = apesim.run_valve(apesim.Machine())
    >>> table = run.to_pandas()[["lift"]].rename(columns={"lift": "lift [m]"}).rename_axis("time [s]")
    >>> about = ['bench = "valve"', "[[run]]", 'data = "a.csv"', 'supply = "1 MPa gauge"', 'temperature = "287 K"']
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "a.csv").write_text(table.to_csv())
    ...     _ = Path(folder, "measured.toml").write_text(chr(10).join([*about, 'pulse = "50 ms"', 'role = "fit"']))
    ...     measured = apesim.read_measured(folder)
    >>> str(measured.bench), [measured_run.data for measured_run in measured.runs]
    ('valve', ['a.csv'])
    """
    arguments = Arguments("read_measured")
    above: float = arguments.quantity("ambient_pressure", ambient_pressure, fields(Ambient)["pressure"])
    if bench is not None and bench not in BENCHES:
        arguments.fault("bench", f"{quoted(bench)} is no bench known here", f"write {' or '.join(BENCHES)}")
    arguments.refuse()

    # A folder of a bench that is of no use is refused alone, before any of its other keys are judged.
    path = Path(folder) / FILE
    data = load_folder_file(path)
    gathered = _Gathered()
    all_faults = gathered.faults
    file, given = str(path), data.get("bench")
    if bench and given in BENCHES and given != bench:
        right = f'give a folder with bench = "{bench}"'
        raise InputError([Fault(file, "bench", f"is the {given}'s; this command takes the {bench}'s alone", right)])

    # From here on faults are gathered. Where no bench is named, the likely one stands in for it, so that this goes on.
    all_faults += find_unknown_keys(file, "", data, TOP_KEYS)
    if given not in BENCHES:
        wrong = f"{quoted(given)} is no bench known here" if "bench" in data else "is not given"
        *others, last = [f'"{name}"' for name in ([bench] if bench else BENCHES)]
        right = f"write bench = {', '.join(others)} or {last}" if others else f"write bench = {last}"
        all_faults.append(Fault(file, "bench", wrong, right))
        given = bench or VALVE

    # What holds for all runs: their noise, what the rig is known to, how it scatters, and how files are written.
    known = Bench(given)
    sensors = SENSORS[known]
    noise = _noise(file, data.get("sensor", {}), sensors.traces | sensors.means, all_faults)
    known_to, known_to_faults = read_table(file, data.get(KNOWN_TO, {}), known)
    scatter, scatter_faults = read_scatter(file, data.get(SCATTER, {}), known)
    all_faults += known_to_faults + scatter_faults
    read = take_read_table(file, READ, data, all_faults)
    names = (*sensors.columns, *(name for name in sensors.computed if name not in sensors.columns))
    is_timed = sensors.axis == TIME
    common, dialect_faults = read_dialect(file, READ, read, names, is_timed=is_timed)
    all_faults += dialect_faults

    # The runs, each with its own [read] over that of the folder. By a wrong one no file is read.
    tables = data.get("run")
    runs: list[MeasuredRun | None] = []
    if not isinstance(tables, list) or not tables or not all(isinstance(run, dict) for run in tables):
        all_faults.append(Fault(file, "run", "no list of runs", 'give each run a table [[run]] with data = "p040.csv"'))
        tables = []
    if len(tables) > MAX_RUNS:  # before the file of any is read
        right = f"share them out over folders of {MAX_RUNS} at most"
        raise InputError([Fault(file, "run", f"{len(tables)} runs, more than the {MAX_RUNS} that are read", right)])
    for number, run in enumerate(tables, 1):
        section, dialect, before = f"run {number}", common, len(gathered.masked)
        if READ in run and common:
            merged = merge_tables(read, take_read_table(file, f"{section}.{READ}", run, all_faults))
            at = f"{section}.{READ}"
            dialect, dialect_faults = read_dialect(file, at, merged, names, is_timed=is_timed)
            all_faults += dialect_faults
        runs.append(_run(path, section, run, known, above, dialect, gathered))
        gathered.masked[before:] = [each._replace(run=number - 1) for each in gathered.masked[before:]]

    # Only what is right is cut into repeats. A record of a cylinder becomes several runs, which changes the numbers of
    # those behind it, and so those of what is masked.
    if all_faults:
        raise InputError(all_faults)
    repeats: list[MeasuredRun] = []
    first_repeats: list[int] = []
    for run in filter(None, runs):
        first_repeats.append(len(repeats))
        try:
            repeats += split_record(run, folder)
        except InputError as error:
            all_faults += error.faults
    if all_faults:
        raise InputError(all_faults)
    hints = tuple(dict.fromkeys([*gathered.hints, *find_absent_sensors(known_to, repeats)]))
    masked = tuple(each._replace(run=first_repeats[each.run]) for each in gathered.masked)
    return Measured(str(folder), noise, tuple(repeats), known, above, hints, known_to, masked, scatter, gathered.tables)


def _noise(file: str, given: Any, sensors: Mapping[str, Any], all_faults: list[Fault]) -> dict[str, float]:
    """Stated standard deviations [SI] by sensor."""
    if not isinstance(given, dict):
        all_faults.append(Fault(file, "sensor", f"{quoted(given)} is no table", "write [sensor.lift]"))
        return {}
    all_faults += find_unknown_keys(file, "sensor", given, sensors)
    noise = {}
    for name in [name for name in sensors if name in given]:
        key, table = f"sensor.{name}", given[name]
        if not isinstance(table, dict):
            all_faults.append(Fault(file, key, f"{quoted(table)} is no table", f"write [{key}]"))
            continue
        all_faults += find_unknown_keys(file, key, table, ("noise",))
        if "noise" in table:
            try:
                noise[name] = sensors[name].read(table["noise"])
            except InvalidValue as wrong:
                all_faults.append(make_fault(file, f"{key}.noise", wrong, sensors[name], sensors[name].ends[1]))
    return noise


def _run(
    path: Path,
    section: str,
    given: dict[str, Any],
    bench: Bench,
    ambient_pressure: float,
    dialect: Dialect | None,
    gathered: _Gathered,
) -> MeasuredRun | None:
    """A run; None if it is wrong, which the faults say. Without a dialect its file is not read."""
    file, all_faults, sensors = str(path), gathered.faults, SENSORS[bench]
    before = len(all_faults)
    all_faults += find_unknown_keys(file, section, given, (*TEXT_KEYS, *sensors.keys, READ))

    # What is due, and the value of each key. A wrong one stays NaN, and the others are read all the same.
    values: dict[str, Any] = dict.fromkeys(sensors.keys, nan) | {"role": 0}
    for key in sensors.due:
        if key not in given:
            all_faults.append(
                Fault(file, f"{section}.{key}", "is not given", f'write {key} = "{_example(key, bench)}"')
            )
    for key, declaration in sensors.keys.items():
        if key in given:
            try:
                values[key] = declaration.read(given[key], ambient_pressure)
            except InvalidValue as wrong:
                shown = EXAMPLES[key]
                all_faults.append(make_fault(file, f"{section}.{key}", wrong, declaration, shown, ambient_pressure))

    # Texts have no declaration that would check them.
    for key in TEXT_KEYS:
        if key in given and not (isinstance(given[key], str) and given[key].strip()):
            right = f'write {key} = "p040{".csv" * (key == "data")}"'
            all_faults.append(Fault(file, f"{section}.{key}", f"{quoted(given[key])} is no text", right))
    if bench == ENGINE:
        all_faults += _engine_faults(file, section, given, values)

    # The file, even where keys are wrong: all faults of a run are to be said at once.
    columns: dict[str, np.ndarray] = {}
    if dialect and isinstance(given.get("data"), str):
        try:
            data = path_below(path.parent, given["data"])
            require_file(data, 'write data = "p040.csv", its path from the folder')
            columns = _columns(data, given["data"], sensors, ambient_pressure, dialect, gathered)
        except InvalidValue as wrong:
            all_faults.append(Fault(file, f"{section}.data", wrong.wrong, wrong.right))

    # Faults of the runs before this one are no reason to leave it out.
    if len(all_faults) > before or dialect is None:
        return None
    return _run_of(given, section, bench, values, columns)


def _example(key: str, bench: Bench) -> Any:
    """A right value of a key."""
    return SENSORS[bench].keys[key].render(EXAMPLES[key], 101325.0) if key in SENSORS[bench].keys else EXAMPLES[key]


def _engine_faults(file: str, section: str, given: dict[str, Any], values: dict[str, Any]) -> Iterator[Fault]:
    """Faults of what no single key of an engine's run shows."""
    means = SENSORS[ENGINE].means
    if not {"data", *means} & given.keys():
        examples = [f'{key} = "{_example(key, ENGINE)}"' for key in ("data", *means)]
        yield Fault(file, section, "nothing is measured", f"write {', '.join(examples[:-1])} or {examples[-1]}")
    angles = values["energise"], values["release"]
    if not np.isnan(angles).any() and (fault := window_fault("energise", "release", angles)):
        yield Fault(file, f"{section}.release", *fault)


def _run_of(
    given: dict[str, Any], section: str, bench: Bench, values: dict[str, Any], columns: dict[str, np.ndarray]
) -> MeasuredRun:
    """A run, made of what was read."""
    data, role = given.get("data", ""), ROLES[values.pop("role")]
    name, supply, temperature = given.get("name", data or section), values["supply"], values["temperature"]

    # What the traces stand over, and what is given of a cylinder, are no channels: they are taken out of the columns.
    if bench == VALVE:
        return MeasuredRun(name, data, supply, temperature, values["pulse"], role, columns.pop(TIME), columns)
    if bench == CYLINDER:
        given_columns = {column: columns.pop(column) for column in SENSORS[bench].given}
        times = columns.pop(TIME)
        return MeasuredRun(name, data, supply, temperature, nan, role, times, columns, bench, given=given_columns)

    # A run of an engine may have means alone: then it has no angles.
    angles = columns.pop(ANGLE, NO_ANGLES)
    return MeasuredRun(
        name,
        data,
        supply,
        temperature,
        nan,
        role,
        (angles - values["energise"]) / values["speed"],
        columns,
        bench,
        values["speed"],
        values["energise"],
        values["release"],
        angles,
        {name: values[name] for name in SENSORS[ENGINE].means if name in given},
        control_supply=values["control_supply"],
    )


def _columns(
    path: Path, name: str, sensors: Sensors, ambient_pressure: float, dialect: Dialect, gathered: _Gathered
) -> dict[str, np.ndarray]:
    """Columns of a file, SI, by name, thinned to what the model resolves; `name` is that of the file in the folder."""
    file, axis, declared = str(path), sensors.axis, sensors.columns
    sensor = "force [N]" if sensors.given else "lift [mm]"
    header = ",".join([f"{axis} [{sensors.axis_unit}]", *(f"{n} [{u}]" for n, u in sensors.given.items()), sensor])
    example = f'give a CSV with the header "{header}"'
    columns, names, wrong, hints, over_range, is_counted, table = read_columns(
        path, declared, (axis, *sensors.given), ambient_pressure, right=example, dialect=dialect
    )

    # What nobody knows among the columns, and what is wrong with those that are known.
    unknown = find_unknown_keys(file, "", [name for name in names if name not in sensors.computed], declared)
    faults = list(dict.fromkeys([*(_name_unknown(fault, dialect) for fault in unknown), *wrong]))
    if not sensors.given:
        faults += find_unknown_start(file, axis, dialect, is_counted=is_counted)
    if not wrong and not sensors.traces.keys() & columns.keys():
        faults.append(Fault(file, "", "no column of a sensor", f'name one in the header, e.g. "{sensor}"'))

    # The values are judged only where all columns are right, and with the command at 0.
    if not faults:
        columns[axis] = shift_to_start(columns[axis], dialect)
        faults += [
            *_too_short(file, axis, columns[axis]),
            *_too_empty(file, columns),
            *_turned_velocity(file, columns[axis], columns),
            *_impossible_cells(file, columns, sensors),
        ]

    # Masked before it is thinned: a mean would spread a disturbance over good samples. What is over range is flagged
    # row by row, as the file has them.
    if not faults:
        if not sensors.given:  # else samples are averaged over cells of the stroke, all columns alike
            columns, masked = mask_disturbances(columns, axis, sensors.traces)
            gathered.masked += masked
        gathered.masked += _over_range(columns[axis], sensors, over_range)
        columns, said = thin(columns, axis)
        hints += [f"{path.name}: {text}" for text in said]
    gathered.faults += faults
    gathered.hints += hints
    if table is not None:
        gathered.tables[name] = table
    return columns


def _over_range(places: np.ndarray, sensors: Sensors, over_range: Mapping[str, np.ndarray]) -> Iterator[Masked]:
    """What is masked as the file says that it is over range: the sensor or the recorder was at its end there."""
    for channel, flags in over_range.items():
        if channel in sensors.traces and flags.any():
            unknown, share = np.full(int(flags.sum()), nan), float(np.mean(flags))
            # a cylinder moves slowly, and no stretch of it is too long
            is_few = share <= MAX_MASKED if sensors.given else is_short(places, flags, sensors.axis)
            yield Masked(0, channel, Disturbance.CLIPPED, places[flags], unknown, share, is_few)


def _name_unknown(fault: Fault, dialect: Dialect) -> Fault:
    """Fault of a column that nobody knows, with the keys of ``[read]`` that would name it."""
    right = fault.right
    if dialect.is_stated or not right.endswith("?"):  # else the name is nearly right
        right = f"{right.removesuffix('?')}, or name it in columns or in ignore of [read], or set ignore_others = true"
    return fault._replace(wrong="unknown column", right=right)


def _too_empty(file: str, columns: Mapping[str, np.ndarray]) -> Iterator[Fault]:
    """Faults of columns with too few numbers to judge anything by."""
    for name, values in columns.items():
        number = int(np.sum(~np.isnan(values)))
        if number < MIN_ROWS <= len(values):
            yield Fault(file, name, f"{number} numbers", f"give at least {MIN_ROWS}, or leave the column out")


def _too_short(file: str, axis: str, values: np.ndarray) -> Iterator[Fault]:
    """Faults of a record that is too short to judge anything by."""
    if axis == ANGLE and len(values) < MIN_ROWS:
        yield Fault(file, axis, f"{len(values)} rows", f"give at least {MIN_ROWS} rows")
    elif axis == TIME and (len(values) < MIN_ROWS or values[-1] <= 0.0):
        short = f"{len(values)} rows up to {values[-1] * 1e3:g} ms"
        right = f"give at least {MIN_ROWS} rows, some after t = 0, when the solenoids are energised"
        yield Fault(file, axis, short, right)


def _impossible_cells(file: str, columns: Mapping[str, np.ndarray], sensors: Sensors) -> Iterator[Fault]:
    """Faults of cells that cannot be, where samples are averaged: a mean would hide them."""
    averaged = (*sensors.given, *sensors.traces) if sensors.given else ()
    for name in [name for name in averaged if name in columns]:
        low, high = find_code_limits(name)
        flags = find_impossible(columns[name], (0.0 if "pressure" in name else low, high))
        if flags.any():
            number, first = int(np.sum(flags)), int(np.argmax(flags))
            wrong = f"{number} value{'s' * (number > 1)} cannot be, the first in row {first + 1}"
            right = "is it a code of the recorder, or gauge called abs? Write nan into cells that are wrong"
            yield Fault(file, name, wrong, right)


def _turned_velocity(file: str, axis: np.ndarray, columns: dict[str, np.ndarray]) -> Iterator[Fault]:
    """Fault of a velocity that falls where the lift beside it rises."""
    if not {"lift", "velocity"} <= columns.keys() or len(axis) < MIN_ROWS:
        return
    is_whole = ~np.isnan(columns["velocity"] + columns["lift"]) & (np.abs(columns["velocity"]) < MAX_VELOCITY)
    axis, velocity, lift = (values[is_whole] for values in (axis, columns["velocity"], columns["lift"]))
    travelled = np.append(0.0, np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(axis)))
    away, lifted = travelled - travelled.mean(), lift - lift.mean()
    if away @ lifted < MAX_TURNED * np.linalg.norm(away) * np.linalg.norm(lifted):
        right = "turn its sign: it is positive as the valve opens (earlier files of apesim valve run have it otherwise)"
        yield Fault(file, "velocity", "falls where the lift rises", right)
