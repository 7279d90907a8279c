"""Soft landings as tables on the terminal and as JSON."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from rich.table import Table

from apesim.studies.soft_landing.braking import ADDED, APART, BRAKE, RELEASE, SPEED, SWITCHED, front_of, widest_soft
from apesim.studies.soft_landing.landing import BOTH, ONLY_A, ONLY_B, SOLENOIDS
from apesim.studies.soft_landing.strokes import FACTORS, KINDS, LIMITS, OFFSETS, ChosenBrake, Result
from apesim.studies.terminal.tables import table_of

SOLENOID_NAMES = {BOTH: "A and B", ONLY_A: "A", ONLY_B: "B"}
BRAKE_HEADER = (
    *("MPa gauge", "stroke", "brake", "solenoids", "edges\n[ms]", "added\n[ms]", "v_e\n[m/s]", "energy left\n[%]"),
    *("worst v_e\n[m/s]", "worst added\n[ms]"),
)


def stroke_json(result: Result, spacing: float, cost: float) -> dict[str, Any]:
    """Lay out the brakes of a stroke at one pressure, for JSON; None where there is no brake.

    The object has conditions, unbraked landing, chosen brakes and fronts; `spacing` is the shortest time between two
    edges of a solenoid [s], `cost` the longest added time allowed [s].
    """
    pressure, temperature = result.task.machine.supply.control()
    wide = widest_soft(result.brakes, result.unbraked, cost)
    fronts = zip(LIMITS, (spacing, 0.0), strict=True)
    return {
        "supply_pressure_Pa": pressure,
        "supply_temperature_K": temperature,
        "stroke": result.task.stroke,
        "unbraked": {
            "contact_ms": 1e3 * result.unbraked.contact,
            "seating_speed_m_s": result.unbraked.speed,
            "seating_energy_J": _energy(result, result.unbraked.speed),
            "lowest_speed_m_s": result.lowest,
        },
        "reachable": bool(result.choices["within_spacing", "softest"]),
        **{limit: {kind: _pattern(result, result.choices[limit, kind]) for kind in KINDS} for limit in LIMITS},
        "needed_spacing_ms": 1e3 * wide[0, APART] if len(wide) else None,
        "front": {
            limit: [
                {
                    "solenoids": _solenoids(row),
                    "edges_ms": _edges(row),
                    "added_ms": 1e3 * row[ADDED],
                    "seating_speed_m_s": row[SPEED],
                }
                for row in front_of(result.brakes, apart)
            ]
            for limit, apart in fronts
        },
    }


def _edges(row: np.ndarray) -> list[float]:
    """The command and the edges of a brake, after the command [ms]."""
    return [0.0, *(round(1e3 * row[column], 6) for column in (BRAKE, RELEASE))]


def _solenoids(row: np.ndarray) -> str:
    """Solenoids that a brake switches."""
    return SOLENOIDS[int(row[SWITCHED])]


def _energy(result: Result, speed: float) -> float:
    """Energy at contact [J]."""
    return 0.5 * result.task.machine.valve.moving_mass * speed**2


def _pattern(result: Result, choice: ChosenBrake | None) -> dict[str, Any] | None:
    """A choice, for JSON; None if there is none."""
    if not choice:
        return None
    conditions = [(factor, offset) for factor in FACTORS for offset in OFFSETS]
    return {
        "solenoids": choice.solenoids,
        "edges_ms": _edges(choice.row),
        "spacing_ms": 1e3 * choice.row[APART],
        "added_ms": 1e3 * choice.row[ADDED],
        "seating_speed_m_s": choice.row[SPEED],
        "seating_energy_J": _energy(result, choice.row[SPEED]),
        "robustness": [
            {
                "pressure_factor": factor,
                "temperature_offset_K": offset,
                "seating_speed_m_s": landing.speed,
                "contact_ms": 1e3 * landing.contact,
                "added_ms": 1e3 * added,
                "stays": landing.stays,
            }
            for (factor, offset), landing, added in zip(conditions, choice.landings, choice.added, strict=True)
        ],
    }


def landing_tables(results: Sequence[Result], spacing: float, cost: float) -> Iterator[Table | str]:
    """Yield the tables of the console: strokes without a brake, the best brakes, and what the columns are.

    Lines stand where there is no table to show; `spacing` is the shortest time between two edges of a solenoid [s],
    `cost` the longest added time allowed [s].

    >>> from apesim.engine.machine import Machine
    >>> from apesim.studies.soft_landing.strokes import soft_landings
    >>> results = soft_landings(Machine(), [0.12e6], 287.0, dwell=50e-3)  # too little pressure to move the piston
    >>> table, *lines = landing_tables(results, spacing=4e-3, cost=1e-3)
    >>> table.row_count, lines[0].strip()
    (2, 'Brakes with edges 4 ms apart, for 1 ms: none lowers the seating speed')
    """
    rows: list[tuple[str, ...]] = []

    # Every stroke without a brake, and how far apart the edges of one can be that lands softly.
    for result in results:
        wide = widest_soft(result.brakes, result.unbraked, cost)
        rows.append(
            (
                f"{result.gauge / 1e6:.3g}",
                result.task.stroke,
                f"{1e3 * result.unbraked.contact:.2f}",
                f"{result.unbraked.speed:.3f}",
                f"{1e3 * _energy(result, result.unbraked.speed):.1f}",
                f"{result.lowest:.3f}",
                f"{1e3 * wide[0, APART]:.2f}" if len(wide) else "-",
            )
        )
    header = ("MPa gauge", "stroke", "contact [ms]", "v_e [m/s]", "energy [mJ]", "lowest [m/s]", "edges apart [ms]")
    yield table_of("Without a brake; edges so far apart that a brake could halve v_e", header, rows, left=(1,))

    # The brakes that were chosen, with and without the solenoids' spacing; a line stands for a table without rows.
    titles = (
        f"Brakes with edges {1e3 * spacing:.3g} ms apart",
        "Brakes with edges as close together as the brake asks for",
    )
    for title, limit in zip(titles, LIMITS, strict=True):
        choices = [(result, kind, result.choices[limit, kind]) for result in results for kind in KINDS]
        rows = [_row(result, kind, choice) for result, kind, choice in choices if choice]
        if rows:
            yield table_of(f"{title}, for {1e3 * cost:.3g} ms", BRAKE_HEADER, (*rows,), left=(1, 2, 3))
        else:
            yield f"{title}, for {1e3 * cost:.3g} ms: none lowers the seating speed\n"

    # What the columns mean, below all the tables that have them.
    yield (
        f"lowest: of the unbraked piston between its peak speed and contact. worst: at {FACTORS[0]:g}, 1 and "
        f"{FACTORS[-1]:g} of the gauge pressure and {OFFSETS[-1]:g} K up and down; ! falls off its stop there"
    )


def _row(result: Result, kind: str, choice: ChosenBrake) -> tuple[str, ...]:
    """Cells of a brake."""
    speeds = [landing.speed for landing in choice.landings]
    worst = "fails" if np.isnan(speeds).any() else f"{max(speeds):.3f}"
    falls = "" if all(landing.stays for landing in choice.landings) else " !"
    return (
        f"{result.gauge / 1e6:.3g}",
        result.task.stroke,
        kind,
        SOLENOID_NAMES[choice.solenoids],
        " ".join(f"{edge:.2f}" for edge in _edges(choice.row)[1:]),
        f"{1e3 * choice.row[ADDED]:.2f}",
        f"{choice.row[SPEED]:.3f}",
        f"{100.0 * (choice.row[SPEED] / result.unbraked.speed) ** 2:.1f}",
        worst + falls,
        f"{1e3 * choice.added.max():.2f}",
    )
