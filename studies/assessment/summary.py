"""An assessment as tables on the terminal and as JSON."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from rich.table import Table

from apesim.archive import Archive
from apesim.studies.assessment.causes import ENTERS, EXERGY, LOSSES, MEASURES
from apesim.studies.assessment.valves import Outcome
from apesim.studies.terminal.tables import number, table_of

HEADINGS = (
    *("ideal", "lateness first", "then speed", "speed first", "then lateness", "lateness mean", "speed mean"),
    *("of it fluct.", "control", "real"),
)
SHOWN = (
    *(("lateness_first", "lateness"), ("lateness_first", "finite_speed"), ("finite_speed_first", "finite_speed")),
    *(("finite_speed_first", "lateness"), ("mean", "lateness"), ("mean", "finite_speed"), ("mean", "fluctuation")),
    ("mean", "control_air"),
)
"""Order and cause of the columns between ideal and real."""
LATE = ("lateness_deg", "delay_deg", "travel_deg", "advance_deg")
LATE_HEADINGS = tuple(
    f"{name} [deg]" for stroke in ("opens late", "closes late") for name in (stroke, "t_d", "travel", "advance")
)
LATE_TITLE = (
    "Lateness of the real valve: delay time t_d (command to 1 % of the stroke, from full lift at closing) and travel "
    "from there to the lap, less the advance of the command"
)
BESIDE = (
    ("energise_deg", 1.0, ".1f", "on [deg]"),
    ("release_deg", 1.0, ".1f", "off [deg]"),
    ("valve_open_deg", 1.0, ".2f", "opens [deg]"),
    ("valve_close_deg", 1.0, ".2f", "closes [deg]"),
    ("peak_lift_m", 1e3, ".2f", "lift [mm]"),
    ("fluctuation", 1.0, ".3f", "opening [-]"),
    ("closing_fluctuation", 1.0, ".3f", "closing [-]"),
    ("intake_pressure_fluctuation_Pa", 1e-5, ".3f", "intake [bar]"),
    ("cycle_to_cycle_torque_Nm", 1.0, ".1e", "cycles [N m]"),
    ("period_cycles", 1.0, ".0f", "period [cycles]"),
)
BESIDE_TITLE = (
    "The real valve: commands and true angles [deg]; fluctuation of both strokes, of the intake's pressure, and of the "
    "torque from cycle to cycle"
)
EXERGY_SHOWN = {
    "ideal": ("engine_air", "indicated_work", "feed", "groove", "exhaust", "other"),
    "real": ("engine_air", "control_air", "indicated_work", "feed", "groove", "exhaust", "valve_drive", "other"),
}
"""Valves whose exergy ledger is shown, and what of it."""
EXPLAINED = (
    "ideal: full groove area at once, from one intended angle to the other; real: the EPV with its control air. "
    "Between them what lateness, finite speed (the real lift, fluctuation included) and control air cost: torque lost, "
    "air added, a gain negative. What lateness and finite speed cost depends on which of them comes first: hence both "
    "orders, and their Shapley mean"
)


def points_of(archive: Archive) -> list[dict[str, Any]]:
    """Lay an assessment out point by point, for JSON.

    Each point has its scalars, ``valves`` with measures and exergy of each, ``losses`` with what each cause costs in
    each order, and ``whole``, the losses of the real valve against the ideal one.

    >>> from apesim.engine.machine import Machine
    >>> from apesim.studies.assessment.grid import assess_speeds
    >>> [point] = points_of(assess_speeds(Machine(), [94.0]))
    >>> losses = point["losses"]["lateness_first"]
    >>> lost = [losses[cause]["brake_torque_lost_Nm"] for cause in ("lateness", "finite_speed", "control_air")]
    >>> bool(np.isclose(sum(lost), point["whole"]["brake_torque_lost_Nm"]))
    True
    """
    v = {name: variable.values for name, variable in archive.variables.items()}
    points = []
    for run, outcome in enumerate(v["outcome"]):
        scalars = {name: v[name][run] for name in v if archive.variables[name].dims == ("run",) and name != "run"}
        names = (*MEASURES, *(f"exergy_{name}_J" for name in EXERGY))
        valves = {valve: {name: v[name][run, i] for name in names} for i, valve in enumerate(v["valve"].tolist())}
        losses = {
            order: {cause: {name: v[name][run, i, j] for name in LOSSES} for j, cause in enumerate(v["cause"].tolist())}
            for i, order in enumerate(v["order"].tolist())
        }
        changes = zip(LOSSES.items(), MEASURES, strict=True)
        whole = {lost: sign * (v[name][run, -1] - v[name][run, 0]) for (lost, sign), name in changes}
        compared = {"outcome": Outcome(outcome).name.lower(), "valves": valves, "losses": losses, "whole": whole}
        points.append(scalars | compared)
    return points


def tables_of(archive: Archive) -> list[Table]:
    """Lay out the tables that the console shows of an assessment.

    They are torque and specific air from the ideal to the real valve, exergy, parts of the lateness, and what stands
    beside.
    """
    v = {name: variable.values for name, variable in archive.variables.items()}
    speeds = [f"{speed:g}" for speed in v["speed_rpm"]]

    # The steps from the ideal to the real valve are chosen by name, whatever order the archive has them in.
    columns = [(v["order"].tolist().index(order), v["cause"].tolist().index(cause)) for order, cause in SHOWN]

    def between(name: str, lost: str, digits: int) -> Iterator[list[str]]:
        for run, speed in enumerate(speeds):
            steps = [v[lost][run, order, cause] for order, cause in columns]
            values = np.array([v[name][run, 0], *steps, v[name][run, -1]]).round(digits) + 0.0  # no -0.00
            yield [speed, *(number(value, f".{digits}f") for value in values)]

    # Of the real valve alone: what stands beside, and the parts of its lateness.
    beside = [
        [speed, *(number(v[name][run] * factor, form) for name, factor, form, _ in BESIDE)]
        for run, speed in enumerate(speeds)
    ]
    late = [
        [speed, *(number(v[f"{stroke}_{name}"][run], ".2f") for stroke in ("opening", "closing") for name in LATE)]
        for run, speed in enumerate(speeds)
    ]

    # Torque and air take the same steps from the ideal to the real valve, and so the same header.
    header = ("r/min", *HEADINGS)
    torque = between("brake_torque_Nm", "brake_torque_lost_Nm", 2)
    air = between("specific_air_kg_per_kWh", "specific_air_added_kg_per_kWh", 1)
    return [
        table_of("Brake torque, and what of it is lost [N m]", header, torque, left=()),
        table_of("All air over brake work, and what is added [kg/kWh]", header, air, left=()),
        *_exergy_tables(v),
        table_of(LATE_TITLE, ("r/min", *LATE_HEADINGS), late, left=()),
        table_of(BESIDE_TITLE, ("r/min", *(heading for *_, heading in BESIDE)), beside, left=()),
    ]


def _exergy_tables(v: dict[str, np.ndarray]) -> list[Table]:
    """Tabulate where the exergy of a cycle goes with the ideal and with the real valve."""
    tables = []
    for valve, names in EXERGY_SHOWN.items():
        at = v["valve"].tolist().index(valve)
        terms = np.column_stack([v[f"exergy_{name}_J"][:, at] for name in names]).round(1) + 0.0  # no -0.0
        rows = [
            [f"{speed:g}", *(number(term, ".1f") for term in of_run)]
            for speed, of_run in zip(v["speed_rpm"], terms, strict=True)
        ]
        title = f"Exergy in a cycle with the {valve} valve [J]: what air brings, and where it goes"
        header = ("r/min", *(f"in: {name}" if name in ENTERS else name for name in names))
        tables.append(table_of(title, [name.replace("_", " ") for name in header], rows, left=()))
    return tables
