"""Summary of corrected commands on the console: a table, and the laws of their delays in words."""

from collections.abc import Sequence
from math import isnan

from rich.table import Table

from apesim.engine.angles import DEGREE
from apesim.studies.tables import INCOMPLETE_MARK, number, table_of
from apesim.studies.timing.grid import TimingMap
from apesim.studies.timing.header import error_text
from apesim.studies.timing.law import Law
from apesim.studies.timing.solve import Reason

FAR_OFF = 1.0 * DEGREE
"""Largest error of a law over all speeds that is shown; with a larger one, the law of each speed is shown [rad]."""
SHOWN = (
    ("speed_rpm", 1.0, 0, "speed\n[r/min]"),
    ("supply_pressure", 1e-6, 2, "supply\n[MPa gauge]"),
    ("supply_temperature", 1.0, 0, "\n[K]"),
    ("advance_deg", 1.0, 2, "advance\n[deg]"),
    ("release_advance_deg", 1.0, 2, "release\n[deg]"),
    ("peak_lift_m", 1e3, 2, "lift\n[mm]"),
    ("brake_torque_Nm", 1.0, 2, "torque\n[N m]"),
    ("uncorrected_brake_torque_Nm", 1.0, 2, "torque\nbefore\n[N m]"),
    ("specific_air_kg_per_kWh", 1.0, 1, "air\n[kg/kWh]"),
    ("uncorrected_specific_air_kg_per_kWh", 1.0, 1, "air\nbefore\n[kg/kWh]"),
    ("shortcut_open_error_deg", 1.0, 2, "opens\n[deg]"),
    ("shortcut_close_error_deg", 1.0, 2, "closes\n[deg]"),
)
LEGEND = (
    f"advance of energising and of release; peak lift ({INCOMPLETE_MARK}: the piston turns back before its open stop); "
    "brake torque, and all air over brake work, corrected and before; "
    "how late the valve opens and closes if the delays of the bench are subtracted"
)


def timing_table(timing_map: TimingMap, ambient_pressure: float) -> Table:
    """Lay out the table that the console shows of corrected commands, a row for each point.

    Parameters
    ----------
    timing_map : TimingMap
        Corrected commands over speed, pressure and temperature.
    ambient_pressure : float
        Pressure of the ambience, above which the supply is shown [Pa abs].

    Returns
    -------
    rich.table.Table
        Advances, lift, torque and specific air, before and after the correction.

    Examples
    --------
    >>> import numpy as np
    >>> from apesim.engine.machine import Machine
    >>> from apesim.studies.timing.grid import map_timing
    >>> from apesim.studies.operating_conditions import Supplies
    >>> timing_map = map_timing(Supplies([1.1e6], [287.0], Machine()), [94.0], jobs=1)
    >>> table = timing_table(timing_map, ambient_pressure=101325.0)
    >>> str(table.title), table.row_count
    ('Commands that open the valve at -5 deg and close it at 70 deg', 1)
    """
    opening, closing = timing_map.command.open_target / DEGREE, timing_map.command.close_target / DEGREE
    title = f"Commands that open the valve at {opening:g} deg and close it at {closing:g} deg"
    source = timing_map.pressure_axis.removesuffix("_pressure")
    header = [*(name.replace("supply", source) for *_, name in SHOWN), "out of reach"]
    return table_of(title, header, _rows(timing_map, ambient_pressure), left=(len(SHOWN),))


def _rows(timing_map: TimingMap, ambient_pressure: float) -> list[list[str]]:
    archive = timing_map.archive
    v = {name: variable.values for name, variable in archive.variables.items()}
    v["supply_pressure"] = v[timing_map.pressure_axis] - ambient_pressure
    marked = (v["full_lift"] == 0) & (v["reachable"] == 1)
    blank = " " * int(marked.any())
    marks = {"peak_lift_m": [INCOMPLETE_MARK if mark else blank for mark in marked]}
    columns = [(v[name] * factor, f".{digits}f", marks.get(name)) for name, factor, digits, _ in SHOWN]
    return [
        [
            *(number(values[run], form) + (mark[run] if mark else "") for values, form, mark in columns),
            _why_not(v["reason"][run]),
        ]
        for run in range(len(archive.runs))
    ]


def _why_not(code: int) -> str:
    """Why targets are out of reach, in words."""
    reason = Reason(code)
    return "" if reason == Reason.REACHED else reason.words


def law_lines(laws: dict[str, list[Law]], ambient_pressure: float) -> list[str]:
    """Write the laws of the temperature in words, a line for each command and pressure.

    Parameters
    ----------
    laws : dict of str to list of Law
        Laws of ``advance`` and ``release_advance``.
    ambient_pressure : float
        Pressure of the ambience, above which the supply is shown [Pa abs].

    Returns
    -------
    list of str
        Each line has the law over all speeds; where that is off by more than `FAR_OFF`, the span of the laws of each
        speed.

    Examples
    --------
    >>> law = Law(1.1e6, 100.0, 6.0e-3, -5e-6, 1e-5, 1e-5, 0.001, 0.001, 3)
    >>> [line] = law_lines({"advance": [law]}, ambient_pressure=0.1e6)
    >>> line.partition(", ")[0]
    'advance at 1 MPa gauge: 6.000 ms -5.00 us/K (supply temperature - 287 K)'
    """
    lines = []
    for name, members in laws.items():
        for pressure in sorted({law.pressure for law in members}):
            here = [law for law in members if law.pressure == pressure]
            over_all = [law for law in here if isnan(law.speed)]
            each = [law for law in here if not isnan(law.speed)]
            far = [law for law in over_all if law.max_angle_error > FAR_OFF]
            chosen = each if far else over_all or each
            gauge = (pressure - ambient_pressure) / 1e6
            lines.append(f"{name.replace('_', ' ')} at {gauge:.3g} MPa gauge{_law_text(chosen, far)}")
    return lines


def _law_text(laws: Sequence[Law], far: Sequence[Law]) -> str:
    """Laws of one pressure in words, with the one over all speeds that is far off, if there is one."""
    against = sum(law.opposite_to_the_paper for law in laws)
    at = f" at {against} of {len(laws)} speeds" if 0 < against < len(laws) else ""
    falls = f"falls with the temperature{at}, against the paper"
    sign = falls if against else "rises with the temperature, as in the paper"
    times, slopes, errors, angles = (
        [factor * getattr(law, name) for law in laws]
        for name, factor in (
            ("at_reference", 1e3),
            ("slope", 1e6),
            ("max_error", 1e3),
            ("max_angle_error", 1.0 / DEGREE),
        )
    )
    scope = f", a law for each speed (one for all is off by {far[0].max_angle_error / DEGREE:.2g} deg)" if far else ""
    return (
        f"{scope}: {_span(times, '.3f')} ms {_span(slopes, '+.2f')} us/K (supply temperature - 287 K), off by at most "
        f"{_span(errors, '.3f')} ms or {_span(angles, '.2f')} deg; it {sign}"
    )


def _span(values: Sequence[float], form: str) -> str:
    low, high = (f"{end:{form}}" for end in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def error_line(timing_map: TimingMap) -> str:
    """Write the error of the interpolated table between its points, in words.

    Parameters
    ----------
    timing_map : TimingMap
        Corrected commands over speed, pressure and temperature.

    Returns
    -------
    str
        A line with largest and root mean square error [deg].

    Examples
    --------
    >>> import numpy as np
    >>> from apesim.engine.machine import Machine
    >>> from apesim.studies.timing.table import Axes, InterpolationError
    >>> axes, tables = Axes(np.array([94.0]), np.array([1.1e6]), np.array([287.0])), np.array([[[0.7]]])
    >>> error = InterpolationError(0, 0, 0, np.nan, np.nan, np.nan, np.nan)
    >>> error_line(TimingMap(Archive("", {}, {}), Machine().command, axes, tables, tables, {}, error))
    'error of the interpolated table: none, as it has one point only'
    """
    return f"error of the interpolated table: {error_text(timing_map.error)}"
