"""Summary of corrected commands on the console: what is reached in words, tables, and the laws of their delays."""

from collections.abc import Sequence
from math import isnan

import numpy as np
from rich.table import Table

from apesim.engine.angles import DEGREE
from apesim.studies.terminal.tables import INCOMPLETE_MARK, number, table_of
from apesim.studies.timing.grid import TimingMap
from apesim.studies.timing.header import error_text
from apesim.studies.timing.law import Law
from apesim.studies.timing.solve import Reason

MAX_LAW_ERROR = 1.0 * DEGREE
"""Largest error of a law over all speeds that is shown; with a larger one, the law of each speed is shown [rad]."""
MAX_SUPPLIES = 9
"""Supplies that have a column each in the tables of commands: more would not fit a terminal."""
SHOWN = (
    ("speed_rpm", "speed\n[r/min]", ".0f"),
    ("energise_deg", "energise at\n[deg]", ".1f"),
    ("release_deg", "release at\n[deg]", ".1f"),
    ("brake_torque_Nm", "torque\n[N m]", ".1f"),
    ("fixed_brake_torque_Nm", "torque, fixed\n[N m]", ".1f"),
    ("specific_air_kg_per_kWh", "air\n[kg/kWh]", ".1f"),
    ("fixed_specific_air_kg_per_kWh", "air, fixed\n[kg/kWh]", ".1f"),
)
"""Columns of the table at one supply, before the one in words: name in the archive, name with unit, format."""


def timing_tables(timing_map: TimingMap, supply: tuple[float, float], ambient_pressure: float) -> list[Table | str]:
    """Lay out what the console shows of corrected commands: a row for each speed.

    First what is reached, in a sentence; then commands, torque and air at the supply of the map nearest to `supply`
    ([Pa abs], [K]), beside those with the machine's own commands; with other supplies, the commands at all of them.
    Gauge pressures are above `ambient_pressure` [Pa abs].
    """
    axes, command = timing_map.axes, timing_map.command
    names = [_supply_text(p - ambient_pressure, t) for p in axes.pressures for t in axes.temperatures]
    values = {
        name: variable.values.reshape(len(axes.speeds), len(names))
        for name, variable in timing_map.archive.variables.items()
    }
    own = _nearest(axes.pressures, supply[0]) * len(axes.temperatures) + _nearest(axes.temperatures, supply[1])
    targets = (
        f"open the valve at {command.open_target / DEGREE:g} deg and close it at {command.close_target / DEGREE:g} deg"
    )
    header = [*(name for _, name, _ in SHOWN), "the valve"]
    source = timing_map.pressure_axis.removesuffix("_pressure")
    title = f"Commands that {targets}; {source} {names[own].replace(chr(10), ', ')}"
    shown: list[Table | str] = [_reached(values), table_of(title, header, _rows(values, own), left=(len(SHOWN),))]
    if 1 < len(names) <= MAX_SUPPLIES:
        for edge, what in (("energise", "open the valve at"), ("release", "close it at")):
            target = command.open_target if edge == "energise" else command.close_target
            title = f"{edge.capitalize()} at [deg], to {what} {target / DEGREE:g} deg"
            shown.append(table_of(title, ["speed\n[r/min]", *names], _commands(values, edge), left=()))
        shown.append(f"{INCOMPLETE_MARK} the piston turns back before its open stop; - out of reach")
    elif len(names) > 1:
        shown.append(f"{len(names) - 1} other supplies: see the files")
    return shown


def _supply_text(gauge: float, temperature: float) -> str:
    """Pressure and temperature of a supply on two lines."""
    return f"{gauge / 1e6:.4g} MPa gauge\n{temperature:.4g} K"


def _nearest(axis: np.ndarray, value: float) -> int:
    return int(np.argmin(np.abs(axis - value)))


def _reached(values: dict[str, np.ndarray]) -> str:
    """What is reached of all points, in a sentence."""
    reachable = values["reachable"] == 1
    turned = int((reachable & (values["full_lift"] == 0)).sum())
    of = f"all {reachable.size}" if reachable.all() else f"{int(reachable.sum())} of {reachable.size}"
    return f"The targets are reached at {of} points; at {turned} of them the piston turns back before its open stop."


def _rows(values: dict[str, np.ndarray], supply: int) -> list[list[str]]:
    """A row for each speed at one supply, with what the valve does in words."""
    here = {name: column[:, supply] for name, column in values.items()}
    return [
        [*(number(here[name][speed], form) for name, _, form in SHOWN), _words(here, speed)]
        for speed in range(len(here["speed_rpm"]))
    ]


def _words(here: dict[str, np.ndarray], speed: int) -> str:
    """What the valve does at a speed with the corrected commands, in words."""
    reason = Reason(here["reason"][speed])
    if reason != Reason.REACHED:
        return f"out of reach: {reason.words}"
    if here["full_lift"][speed]:
        return "opens fully"
    return f"turns back at {1e3 * here['peak_lift_m'][speed]:.1f} mm"


def _commands(values: dict[str, np.ndarray], edge: str) -> list[list[str]]:
    """A row for each speed with the command angles of one edge at all supplies."""
    marked = (values["full_lift"] == 0) & (values["reachable"] == 1)
    blank = " " * int(marked.any())
    return [
        [
            f"{speeds[0]:.0f}",
            *(
                number(angle, ".1f") + (INCOMPLETE_MARK if mark else blank)
                for angle, mark in zip(angles, marks, strict=True)
            ),
        ]
        for speeds, angles, marks in zip(values["speed_rpm"], values[f"{edge}_deg"], marked, strict=True)
    ]


def shortcut_line(timing_map: TimingMap) -> str:
    """Write what the delays of the bench would give in place of these commands, in a sentence.

    It has the largest errors of the angles, and the speed from which the valve would not open everywhere.
    """
    v = {name: variable.values for name, variable in timing_map.archive.variables.items()}
    opens, closes = v["shortcut_open_error_deg"], v["shortcut_close_error_deg"]
    missed = np.isnan(opens)
    start = "With the delays of the bench instead, as they are at rest, the valve would "
    if missed.all():
        return f"{start}open at none of these points"
    text = (
        f"{start}open up to {np.nanmax(np.abs(opens)):.2g} deg and close up to {np.nanmax(np.abs(closes)):.2g} deg off"
    )
    return f"{text}, and from {v['speed_rpm'][missed].min():.0f} r/min on not open everywhere" if missed.any() else text


def law_lines(laws: dict[str, list[Law]], ambient_pressure: float) -> list[str]:
    """Write the laws of the temperature in words, a line for each command and pressure.

    `laws` has those of ``advance`` and ``release_advance``; where the law over all speeds is off by more than
    `MAX_LAW_ERROR`, its line has the span of the laws of each speed. Gauge pressures are above `ambient_pressure` [Pa
    abs].
    """
    lines = []
    for name, members in laws.items():
        for pressure in sorted({law.pressure for law in members}):
            here = [law for law in members if law.pressure == pressure]
            over_all = [law for law in here if isnan(law.speed)]
            each = [law for law in here if not isnan(law.speed)]
            far = [law for law in over_all if law.max_angle_error > MAX_LAW_ERROR]
            chosen = each if far else over_all or each
            gauge = (pressure - ambient_pressure) / 1e6
            lines.append(f"{name.replace('_', ' ')} at {gauge:.3g} MPa gauge{_law_text(chosen, far)}")
    return lines


def _law_text(laws: Sequence[Law], far: Sequence[Law]) -> str:
    """Laws of one pressure in words, with the one over all speeds that is far off, if there is one."""
    falling = sum(law.slope < 0.0 for law in laws)
    at = f" at {falling} of {len(laws)} speeds" if 0 < falling < len(laws) else ""
    sign = f"falls with the temperature{at}" if falling else "rises with the temperature"
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
    """Write the largest and rms error of the interpolated table between its points [deg], in words."""
    return f"error of the interpolated table: {error_text(timing_map.error)}"
