"""The best commands as a table on the terminal and as JSON."""

from collections.abc import Iterator, Sequence
from typing import Any

from rich.table import Table

from apesim.studies.optimise.landscape import Point
from apesim.studies.optimise.search import Optimum
from apesim.studies.optimise.table import BOUNDS, NAMES, bounds_of, row_of, speed_rpm
from apesim.studies.terminal.tables import number, table_of

HEADER = (
    *("speed\n[r/min]", "commands", "energise\n[deg]", "release\n[deg]", "supply\n[MPa gauge]", "opens\n[deg]"),
    *("closes\n[deg]", "peak lift\n[mm]", "full lift", "brake torque\n[N m]", "all air\n[kg/kWh]"),
)


def point_json(optimum: Optimum) -> dict[str, Any]:
    """Lay out the optima and the Pareto front of a speed, for JSON.

    It has the speed, the machine's own commands under ``fixed``, each goal by its name, and the points of the
    ``front``.

    >>> from apesim.studies.optimise.landscape import RECORDED, Goal, Point
    >>> point = Point((0.7, 1.0), -1.0, 4.2, 1.1e6, dict.fromkeys(RECORDED, 1.0), (60.0, 57e3), True)
    >>> optimum = Optimum(94.0, point, {Goal.TORQUE: point}, [], 81, 27)
    >>> data = point_json(optimum)
    >>> round(data["most_torque"]["energise_deg"], 1), data["most_torque"]["bounds"], data["front"]
    (-57.3, {'duration': 'highest'}, [])
    """

    def stated(point: Point | None, **more: Any) -> dict[str, Any] | None:
        return row_of(point) | {"full_lift": point.full_lift} | more if point else None

    data: dict[str, Any] = {"speed_rpm": speed_rpm(optimum), "fixed": stated(optimum.fixed)}
    for goal, point in optimum.best.items():
        bounds = {name: BOUNDS[code] for name, code in bounds_of(point).items() if code}
        data[NAMES[goal]] = stated(point, bounds=bounds)
    front = [stated(point) for point in optimum.front]
    return data | {"front": front, "sketches": optimum.sketches, "runs": optimum.runs}


def optimum_table(optima: Sequence[Optimum], ambient_pressure: float) -> Table:
    """Lay out the table that the console shows: the best commands beside the machine's own, for each speed.

    The supply is shown above `ambient_pressure` [Pa abs].
    """
    rows = [row for optimum in optima for row in _rows(optimum, ambient_pressure)]
    return table_of("The best commands", HEADER, rows, left=(1, 8))


def _rows(optimum: Optimum, ambient_pressure: float) -> Iterator[tuple[str, ...]]:
    """A row for the machine's own commands and one for each goal."""
    points = {"fixed": optimum.fixed} | {NAMES[goal]: point for goal, point in optimum.best.items()}
    for name, point in points.items():
        row = row_of(point)
        yield (
            f"{speed_rpm(optimum):g}",
            name.replace("_", " "),
            number(row["energise_deg"], ".2f"),
            number(row["release_deg"], ".2f"),
            number((row["supply_pressure"] - ambient_pressure) / 1e6, ".3f"),
            number(row["valve_open_deg"], ".2f"),
            number(row["valve_close_deg"], ".2f"),
            number(row["peak_lift_m"] * 1e3, ".3f"),
            ("yes" if point.full_lift else "no") if point else "-",
            number(row["brake_torque_Nm"], ".2f"),
            number(row["specific_air_kg_per_kWh"], ".1f"),
        )


def end_lines(optima: Sequence[Optimum]) -> Iterator[str]:
    """Write a line on each optimum that lies at an end of the range that was searched.

    >>> from apesim.studies.optimise.landscape import RECORDED, Goal, Point
    >>> point = Point((0.7, 1.0), -1.0, 4.2, 1.1e6, dict.fromkeys(RECORDED, 1.0), (60.0, 57e3), True)
    >>> optimum = Optimum(94.0, point, {Goal.TORQUE: point}, [], 81, 27)
    >>> list(end_lines([optimum]))
    ['897.634 r/min, most torque: at the highest duration searched']
    """
    for optimum in optima:
        for goal, point in optimum.best.items():
            for key, code in bounds_of(point).items():
                if code:
                    what = f"{speed_rpm(optimum):g} r/min, {NAMES[goal].replace('_', ' ')}"
                    yield f"{what}: at the {BOUNDS[code]} {key.replace('_', ' ')} searched"
