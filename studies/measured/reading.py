"""A folder of measured data, read strictly.

All that is wrong is reported at once, each fault with its file, its key or column, and the right form.
"""

import difflib
import tomllib
from collections.abc import Collection, Iterator, Mapping
from math import nan
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from apesim.engine.machine import Machine, window_fault
from apesim.quantities import Fault, InputError, InvalidValue, make_fault, quoted
from apesim.quantities.files import path_below, text_of
from apesim.studies.measured.columns import TIME, read_columns
from apesim.studies.measured.runs import BENCHES, ENGINE, NO_ANGLES, ROLES, VALVE, Bench, Measured, MeasuredRun
from apesim.studies.measured.sensors import ANGLE, EXAMPLES, FILE, SENSORS, Sensors

STANDARD_AMBIENT = Machine().ambient.pressure
"""Pressure that gauge pressures stand above in the default machine [Pa abs]."""
TOP_KEYS = ("bench", "sensor", "run")
"""Keys at the top of the file."""
TEXT_KEYS = ("data", "name")
"""Keys of a run that are texts."""
MIN_ROWS = 8
"""Rows of a record: with fewer no noise can be estimated."""
MAX_TURNED = -0.5
"""Correlation of the lift with the integral of the velocity, below which the sign is the wrong one: of an ideal pair it
is 1, or -1 if turned; noise and drifts only bring it nearer to 0."""


def read_measured(
    folder: str | PathLike[str], ambient_pressure: float = STANDARD_AMBIENT, bench: str | None = None
) -> Measured:
    """Read a folder of measured data.

    Parameters
    ----------
    folder : path
    ambient_pressure : float
        Pressure that gauge pressures stand above [Pa abs]; the default machine's if left out.
    bench : {"valve", "engine"}, optional
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
    path = Path(folder) / FILE
    data = _toml(path)
    all_faults: list[Fault] = []
    file, given = str(path), data.get("bench")
    if bench and given in BENCHES and given != bench:
        right = f'give a folder with bench = "{bench}"'
        raise InputError([Fault(file, "bench", f"is the {given}'s; this command takes the {bench}'s alone", right)])
    all_faults += _unknown(file, "", data, TOP_KEYS)
    if given not in BENCHES:
        wrong = f"{quoted(given)} is no bench known here" if "bench" in data else "is not given"
        forms = [f'bench = "{name}"' for name in ([bench] if bench else BENCHES)]
        all_faults.append(Fault(file, "bench", wrong, f"write {' or '.join(forms)}"))
        given = bench or VALVE
    known = Bench(given)
    sensors = SENSORS[known]
    noise = _noise(file, data.get("sensor", {}), sensors.traces | sensors.means, all_faults)
    tables = data.get("run")
    runs: list[MeasuredRun | None] = []
    if not isinstance(tables, list) or not tables or not all(isinstance(run, dict) for run in tables):
        all_faults.append(Fault(file, "run", "no list of runs", 'give each run a table [[run]] with data = "p040.csv"'))
        tables = []
    for number, run in enumerate(tables, 1):
        runs.append(_run(path, f"run {number}", run, known, ambient_pressure, all_faults))
    if all_faults:
        raise InputError(all_faults)
    return Measured(str(folder), noise, tuple(run for run in runs if run), known, ambient_pressure)


def _toml(path: Path) -> dict[str, Any]:
    """Contents of the file of a folder."""
    try:
        return tomllib.loads(text_of(path_below(path.parent, path.name)))
    except InvalidValue as wrong:
        right = wrong.right or f"give a folder with {FILE} and the CSV files that it names"
        raise InputError([Fault(str(path), "", wrong.wrong, right)]) from None
    except (ValueError, RecursionError) as error:
        what, _, where = str(error).partition(" (at ")
        right = 'write key = "value", a quantity in quotes: pulse = "50 ms"'
        raise InputError([Fault(str(path), where.rstrip(")"), f"no TOML: {what}", right)]) from None


def _unknown(file: str, section: str, given: Collection[str], valid: Collection[str]) -> Iterator[Fault]:
    """Faults of the keys that nobody knows."""
    for key in given:
        if key not in valid:
            near = difflib.get_close_matches(key, valid, n=1)
            right = f"did you mean {near[0]}?" if near else f"valid here: {', '.join(valid)}"
            yield Fault(file, f"{section}.{key}".lstrip("."), "unknown key", right)


def _noise(file: str, given: Any, sensors: Mapping[str, Any], all_faults: list[Fault]) -> dict[str, float]:
    """Stated standard deviations [SI] by sensor."""
    if not isinstance(given, dict):
        all_faults.append(Fault(file, "sensor", f"{quoted(given)} is no table", "write [sensor.lift]"))
        return {}
    all_faults += _unknown(file, "sensor", given, sensors)
    noise = {}
    for name in [name for name in sensors if name in given]:
        key, table = f"sensor.{name}", given[name]
        if not isinstance(table, dict):
            all_faults.append(Fault(file, key, f"{quoted(table)} is no table", f"write [{key}]"))
            continue
        all_faults += _unknown(file, key, table, ("noise",))
        if "noise" in table:
            try:
                noise[name] = sensors[name].read(table["noise"])
            except InvalidValue as wrong:
                all_faults.append(make_fault(file, f"{key}.noise", wrong, sensors[name], sensors[name].ends[1]))
    return noise


def _run(
    path: Path, section: str, given: dict[str, Any], bench: Bench, ambient_pressure: float, all_faults: list[Fault]
) -> MeasuredRun | None:
    """A run; None if it is wrong, which the all_faults say."""
    file, before, sensors = str(path), len(all_faults), SENSORS[bench]
    all_faults += _unknown(file, section, given, (*TEXT_KEYS, *sensors.keys))
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
    for key in TEXT_KEYS:
        if key in given and not (isinstance(given[key], str) and given[key].strip()):
            right = f'write {key} = "p040{".csv" * (key == "data")}"'
            all_faults.append(Fault(file, f"{section}.{key}", f"{quoted(given[key])} is no text", right))
    if bench == ENGINE:
        all_faults += _engine_faults(file, section, given, values)
    columns: dict[str, np.ndarray] = {}
    if isinstance(given.get("data"), str):
        try:
            columns = _columns(path_below(path.parent, given["data"]), sensors, ambient_pressure, all_faults)
        except InvalidValue as wrong:
            all_faults.append(Fault(file, f"{section}.data", wrong.wrong, wrong.right))
    if len(all_faults) > before:
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
    if bench == VALVE:
        return MeasuredRun(name, data, supply, temperature, values["pulse"], role, columns.pop(TIME), columns)
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
    )


def _columns(path: Path, sensors: Sensors, ambient_pressure: float, all_faults: list[Fault]) -> dict[str, np.ndarray]:
    """Columns of a CSV, SI, by name."""
    file, axis, declared = str(path), sensors.axis, sensors.columns
    example = f'give a CSV with the header "{axis} [{sensors.axis_unit}],lift [mm]", its path from the folder'
    columns, names, wrong = read_columns(path, declared, (axis,), ambient_pressure, example)
    faults = [*_unknown(file, "", [name for name in names if name not in sensors.computed], declared), *wrong]
    if names and not wrong and not sensors.traces.keys() & columns.keys():
        faults.append(Fault(file, "", "no column of a sensor", 'name one in the header, e.g. "lift [mm]"'))
    if not faults:
        faults += [*_too_short(file, axis, columns[axis]), *_turned_velocity(file, columns[axis], columns)]
    all_faults += faults
    return columns


def _too_short(file: str, axis: str, values: np.ndarray) -> Iterator[Fault]:
    """Faults of a record that is too short to judge anything by."""
    if axis == ANGLE and len(values) < MIN_ROWS:
        yield Fault(file, axis, f"{len(values)} rows", f"give at least {MIN_ROWS} rows")
    elif axis == TIME and (len(values) < MIN_ROWS or values[-1] <= 0.0):
        short = f"{len(values)} rows up to {values[-1] * 1e3:g} ms"
        right = f"give at least {MIN_ROWS} rows, some after t = 0, when the solenoids are energised"
        yield Fault(file, axis, short, right)


def _turned_velocity(file: str, axis: np.ndarray, columns: dict[str, np.ndarray]) -> Iterator[Fault]:
    """Fault of a velocity that falls where the lift beside it rises."""
    if not {"lift", "velocity"} <= columns.keys() or len(axis) < MIN_ROWS:
        return
    velocity = columns["velocity"]
    travelled = np.append(0.0, np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(axis)))
    away, lifted = travelled - travelled.mean(), columns["lift"] - columns["lift"].mean()
    if away @ lifted < MAX_TURNED * np.linalg.norm(away) * np.linalg.norm(lifted):
        right = "turn its sign: it is positive as the valve opens (earlier files of apesim valve run have it otherwise)"
        yield Fault(file, "velocity", "falls where the lift rises", right)
