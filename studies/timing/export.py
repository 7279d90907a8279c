"""The map of corrected commands for other programs: CSV, JSON, and the C header."""

import json
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from apesim.archive import Archive, ArchiveError, write_file
from apesim.archive.writing import format_csv
from apesim.engine.angles import DEGREE, TURN
from apesim.studies.execution.output import refuse_to_replace
from apesim.studies.terminal.console import plain
from apesim.studies.timing.grid import CRITERION, TimingMap
from apesim.studies.timing.header import c_header, error_text
from apesim.studies.timing.law import Law
from apesim.studies.timing.solve import Reason


def as_json(timing_map: TimingMap) -> dict[str, Any]:
    """Convert a map of corrected commands to one object for JSON; its keys end in the units.

    It has targets, axes, tables, laws, the error of interpolation, and all results point by point.
    """
    axes, error, command = timing_map.axes, timing_map.error, timing_map.command
    v = {name: variable.values for name, variable in timing_map.archive.variables.items()}

    # Results point by point: flags are booleans and the reason is a word, as JSON has no legend for codes.
    points = []
    for run in v["run"]:
        point = {name: values[run] for name, values in v.items() if name != "run"}
        reason = Reason(point["reason"])
        point |= {name: bool(point[name]) for name in ("reachable", "full_lift")}
        point["reason"] = reason.name.lower()
        point["remedy"] = None if reason == Reason.REACHED else reason.remedy
        points.append(point)

    # The whole map in the units that the keys end in, where the map itself holds radians; NaN becomes null.
    return plain(
        {
            "target_deg": {"open": command.open_target / DEGREE, "close": command.close_target / DEGREE},
            "criterion": CRITERION,
            "axes": {
                "speed_rpm": np.unique(v["speed_rpm"]),
                f"{timing_map.pressure_axis}_Pa": axes.pressures,
                "supply_temperature_K": axes.temperatures,
            },
            "advance_deg": timing_map.advance / DEGREE,
            "release_advance_deg": timing_map.release_advance / DEGREE,
            "reachable": ~np.isnan(timing_map.advance),
            "interpolation_error": {
                "where": "centres of cells",
                "advance_most_deg": error.max_advance_error / DEGREE,
                "advance_rms_deg": error.advance_error_rms / DEGREE,
                "release_advance_most_deg": error.max_release_error / DEGREE,
                "release_advance_rms_deg": error.release_error_rms / DEGREE,
                "points": error.points,
                "centres": error.centres,
                "seed": error.seed,
                "measured": error_text(error),
            },
            "temperature_law": {
                name: [_law(law, timing_map.pressure_axis) for law in laws] for name, laws in timing_map.laws.items()
            },
            "points": points,
        }
    )


def _law(law: Law, pressure_axis: str) -> dict[str, Any]:
    """Convert a law to milliseconds and degrees; its speed is NaN where it is that of all speeds."""
    return {
        f"{pressure_axis}_Pa": law.pressure,
        "speed_rpm": law.speed / TURN * 60.0,
        "at_287_K_ms": law.at_reference * 1e3,
        "slope_ms_per_K": law.slope * 1e3,
        "error_most_ms": law.max_error * 1e3,
        "error_rms_ms": law.error_rms * 1e3,
        "error_most_deg": law.max_angle_error / DEGREE,
        "error_rms_deg": law.angle_error_rms / DEGREE,
        "points": law.points,
        "opposite_to_the_paper": law.opposite_to_the_paper,
    }


def _as_csv(archive: Archive) -> str:
    """The results of all points of a map as CSV; headers carry units."""
    variables = {name: variable for name, variable in archive.variables.items() if name != "run"}
    columns = [variable.values.tolist() for variable in variables.values()]
    names = list(variables)
    columns[names.index("reason")] = [Reason(code).name.lower() for code in columns[names.index("reason")]]
    header = [f"{name} [{variable.unit}]" if variable.unit != "1" else name for name, variable in variables.items()]
    return format_csv(header, zip(*columns, strict=True))


def export(timing_map: TimingMap, out: Path) -> list[Path]:
    """Write a map of corrected commands beside its archive `out`, as ``.csv``, ``.json`` and C header ``.h``.

    Raises ArchiveError where a file cannot be written.
    """
    paths = exports_of(out)
    text = json.dumps(as_json(timing_map), indent=1, allow_nan=False)
    for path, content in zip(paths, (_as_csv(timing_map.archive), text + "\n", c_header(timing_map)), strict=True):
        write_file(path, content)
    return paths


def refuse_exports(out: Path, *, overwrite: bool) -> None:
    """Refuse an archive beside which the CSV, JSON and C header of a map are not to be written.

    Raises ArchiveError where the archive has the name of one of these files, or one is there and is no file or must not
    be replaced.

    >>> try:
    ...     refuse_exports(Path("timing.json"), overwrite=False)
    ... except ArchiveError as error:
    ...     error.what
    'is the name of an export beside the archive'
    """
    if out in exports_of(out):
        raise ArchiveError(out, "is the name of an export beside the archive", "choose e.g. --out timing.h5")
    for path in exports_of(out):
        refuse_to_replace(path, overwrite=overwrite)


def exports_of(out: str | PathLike[str]) -> list[Path]:
    """Name the files of a map that stand beside its archive `out`: CSV, JSON and C header."""
    return [Path(out).with_suffix(ending) for ending in (".csv", ".json", ".h")]
