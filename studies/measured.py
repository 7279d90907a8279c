"""Measured data: a folder with ``measured.toml`` and the CSV files that it names, read strictly.

All that is wrong is told at once, each fault with its file, its key or column, and the right form::

    bench = "valve"
    [sensor.lift]
    noise = "0.03 mm"
    [[run]]
    data = "p040.csv"                # header: time [ms], lift [mm], pressure_a [kPa abs], ...
    supply = "0.40 MPa gauge"
    temperature = "287 K"
    pulse = "50 ms"
    role = "fit"                     # "gate": never fitted, refuses a model that it contradicts; "check": only reported

Inside all is SI and absolute. Time starts as the solenoids are energised; what lies before is at rest.
"""

import difflib
import tomllib
from math import nan
from pathlib import Path
from typing import NamedTuple

import numpy as np

from apesim.quantities import Choice, Culprit, InputError, Pressure, Quantity, Wrong, culprit, quoted
from apesim.quantities.files import text_of
from studies.columns import TIME, read_columns

FILE = "measured.toml"
FIT, GATE, CHECK = ROLES = ("fit", "gate", "check")
TOP_KEYS = ("bench", "sensor", "run")
RUN_KEYS = {
    "supply": Pressure(0.02, 30, FILE, show="gauge"),
    "temperature": Quantity("K", 150, 600, FILE),
    "pulse": Quantity("ms", 0.01, 60000, FILE),
    "role": Choice(ROLES, FILE),
}
TEXT_KEYS = ("data", "name")
DUE_KEYS = ("data", "supply", "pulse")
EXAMPLES = {"supply": 0.40e6 + 101325.0, "temperature": 287.0, "pulse": 50e-3, "role": 0}
SENSORS = {
    "lift": Quantity("mm", 1e-9, 100, FILE),
    "velocity": Quantity("m/s", 1e-9, 1000, FILE),
    "pressure_a": Quantity("kPa", 1e-9, 30000, FILE),
    "pressure_b": Quantity("kPa", 1e-9, 30000, FILE),
    "temperature_a": Quantity("K", 1e-9, 100, FILE),
    "temperature_b": Quantity("K", 1e-9, 100, FILE),
}
"""What a sensor measures, and how its noise is given."""
COLUMNS = {TIME: "ms"} | {name: sensor.unit + " abs" * name.startswith("pressure") for name, sensor in SENSORS.items()}
FEWEST_ROWS = 8


class MeasuredRun(NamedTuple):
    """One run on the valve's bench."""

    name: str
    """Repeats share it."""
    data: str
    supply: float
    """[Pa abs]"""
    temperature: float
    """Of the supply [K]; NaN: the machine's."""
    pulse: float
    """Time for which the solenoids are energised [s]."""
    role: str
    times: np.ndarray
    """Since the solenoids were energised [s], shape (n,), ascending."""
    channels: dict
    """SI values, each of shape (n,), by the name of the sensor; the velocity is positive as the valve closes."""


class Measured(NamedTuple):
    """A folder of measured data."""

    folder: str
    noise: dict
    """Standard deviations that the user states, SI, by the name of the sensor."""
    runs: tuple

    def of(self, role):
        """The runs of a role."""
        return [run for run in self.runs if run.role == role]


def read_measured(folder, ambient_pressure):
    """Read a folder of measured data from the valve's bench.

    Parameters
    ----------
    folder : path
    ambient_pressure : float
        What gauge pressures stand above [Pa].

    Returns
    -------
    Measured

    Raises
    ------
    InputError
        With a culprit for each fault.
    """
    path = Path(folder) / FILE
    data, culprits = _toml(path), []
    file = str(path)
    culprits += _unknown(file, "", data, TOP_KEYS)
    if data.get("bench") != "valve":
        given = f"{quoted(data['bench'])} is no bench known here" if "bench" in data else "is not given"
        culprits.append(Culprit(file, "bench", given, 'write bench = "valve"'))
    noise = _noise(file, data.get("sensor", {}), culprits)
    given, runs = data.get("run"), []
    if not isinstance(given, list) or not given or not all(isinstance(run, dict) for run in given):
        culprits.append(Culprit(file, "run", "no list of runs", 'give each run a table [[run]] with data = "p040.csv"'))
        given = []
    for number, run in enumerate(given, 1):
        runs.append(_run(path, f"run {number}", run, ambient_pressure, culprits))
    if culprits:
        raise InputError(culprits)
    return Measured(str(folder), noise, tuple(runs))


def _toml(path):
    """What stands in the file of a folder."""
    try:
        return tomllib.loads(text_of(path))
    except Wrong as wrong:
        right = wrong.right or f"give a folder with {FILE} and the CSV files that it names"
        raise InputError([Culprit(str(path), "", wrong.wrong, right)]) from None
    except (ValueError, RecursionError) as error:
        what, _, where = str(error).partition(" (at ")
        right = 'write key = "value", a quantity in quotes: pulse = "50 ms"'
        raise InputError([Culprit(str(path), where.rstrip(")"), f"no TOML: {what}", right)]) from None


def _unknown(file, section, given, valid):
    """Culprits of the keys that nobody knows."""
    for key in given:
        if key not in valid:
            near = difflib.get_close_matches(key, valid, n=1)
            right = f"did you mean {near[0]}?" if near else f"valid here: {', '.join(valid)}"
            yield Culprit(file, f"{section}.{key}".lstrip("."), "unknown key", right)


def _noise(file, sensors, culprits):
    """Stated standard deviations [SI] by sensor."""
    if not isinstance(sensors, dict):
        culprits.append(Culprit(file, "sensor", f"{quoted(sensors)} is no table", "write [sensor.lift]"))
        return {}
    culprits += _unknown(file, "sensor", sensors, SENSORS)
    noise = {}
    for name in SENSORS.keys() & sensors.keys():
        key, sensor = f"sensor.{name}", sensors[name]
        if not isinstance(sensor, dict):
            culprits.append(Culprit(file, key, f"{quoted(sensor)} is no table", f"write [{key}]"))
            continue
        culprits += _unknown(file, key, sensor, ("noise",))
        if "noise" in sensor:
            try:
                noise[name] = SENSORS[name].read(sensor["noise"])
            except Wrong as wrong:
                culprits.append(culprit(file, f"{key}.noise", wrong, SENSORS[name], SENSORS[name].ends[1]))
    return noise


def _run(path, section, given, ambient_pressure, culprits):
    """A run; None if it is wrong, of which the culprits tell."""
    file, before = str(path), len(culprits)
    culprits += _unknown(file, section, given, (*TEXT_KEYS, *RUN_KEYS))
    values = {"temperature": nan, "role": 0}
    for key in DUE_KEYS:
        if key not in given:
            example = RUN_KEYS[key].render(EXAMPLES[key], 101325.0) if key in RUN_KEYS else "p040.csv"
            culprits.append(Culprit(file, f"{section}.{key}", "is not given", f'write {key} = "{example}"'))
    for key, declaration in RUN_KEYS.items():
        if key in given:
            try:
                values[key] = declaration.read(given[key], ambient_pressure)
            except Wrong as wrong:
                example = EXAMPLES[key]
                culprits.append(culprit(file, f"{section}.{key}", wrong, declaration, example, ambient_pressure))
    for key in TEXT_KEYS:
        if key in given and not (isinstance(given[key], str) and given[key].strip()):
            right = f'write {key} = "p040{".csv" * (key == "data")}"'
            culprits.append(Culprit(file, f"{section}.{key}", f"{quoted(given[key])} is no text", right))
    if len(culprits) > before and not isinstance(given.get("data"), str):
        return None
    columns = _columns(path.parent / given["data"], ambient_pressure, culprits)
    if len(culprits) > before:
        return None
    name, role = given.get("name", given["data"]), ROLES[values["role"]]
    times = columns.pop(TIME)
    return MeasuredRun(
        name, given["data"], values["supply"], values["temperature"], values["pulse"], role, times, columns
    )


def _columns(path, ambient_pressure, culprits):
    """The columns of a CSV, SI, by name."""
    file, example = str(path), 'give a CSV with the header "time [ms],lift [mm]", its path from the folder'
    columns, names, wrong = read_columns(path, COLUMNS, (TIME,), ambient_pressure, example)
    found = [*_unknown(file, "", names, COLUMNS), *wrong]
    if names and not SENSORS.keys() & set(names):
        found.append(Culprit(file, "", "no column of a sensor", 'name one in the header, e.g. "lift [mm]"'))
    if not found and (len(columns[TIME]) < FEWEST_ROWS or columns[TIME][-1] <= 0.0):
        short = f"{len(columns[TIME])} rows up to {columns[TIME][-1] * 1e3:g} ms"
        right = f"give at least {FEWEST_ROWS} rows, some after t = 0, when the solenoids are energised"
        found.append(Culprit(file, TIME, short, right))
    culprits += found
    return columns
