"""The best commands as a table on the terminal and as JSON."""

from collections.abc import Iterator, Sequence

from rich.table import Table

from apesim.studies.optimise.landscape import Point
from apesim.studies.optimise.search import Optimum
from apesim.studies.optimise.table import BOUNDS, NAMES, bounds_of, row_of, speed_rpm
from apesim.studies.tables import number, table_of

HEADER = (
    *("speed\n[r/min]", "commands", "energise\n[deg]", "release\n[deg]", "supply\n[MPa gauge]", "opens\n[deg]"),
    *("closes\n[deg]", "peak lift\n[mm]", "full lift", "brake torque\n[N m]", "all air\n[kg/kWh]"),
)


def point_json(one: Optimum) -> dict:
    """Optima and Pareto front of a speed, for JSON."""

    def told(point: Point | None, **more: dict) -> dict | None:
        return row_of(point) | {"full_lift": point.full_lift} | more if point else None

    found: dict = {"speed_rpm": speed_rpm(one), "uncorrected": told(one.own)}
    for goal, point in one.best.items():
        bounds = {name: BOUNDS[code] for name, code in bounds_of(point).items() if code}
        found[NAMES[goal]] = told(point, bounds=bounds)
    return found | {"front": [told(point) for point in one.front], "sketches": one.sketches, "runs": one.runs}


def optimum_table(optima: Sequence[Optimum], ambient_pressure: float) -> Table:
    """The best commands beside the machine's own, for each speed."""
    rows = [row for one in optima for row in _rows(one, ambient_pressure)]
    return table_of("The best commands", HEADER, rows, left=(1, 8))


def _rows(one: Optimum, ambient_pressure: float) -> Iterator[tuple[str, ...]]:
    """A row for the machine's own commands and one for each goal."""
    points = {"uncorrected": one.own} | {NAMES[goal]: point for goal, point in one.best.items()}
    for name, point in points.items():
        row = row_of(point)
        yield (
            f"{speed_rpm(one):g}",
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
    """A line on each optimum that lies at an end of the range searched."""
    for one in optima:
        for goal, point in one.best.items():
            for key, code in bounds_of(point).items():
                if code:
                    what = f"{speed_rpm(one):g} r/min, {NAMES[goal].replace('_', ' ')}"
                    yield f"{what}: at the {BOUNDS[code]} {key.replace('_', ' ')} searched"
