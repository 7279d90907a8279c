"""Discharge tests as a table on the terminal and as JSON."""

from collections.abc import Iterator
from math import inf, nan
from pathlib import Path
from typing import Any

from rich.table import Table

from apesim.studies.discharge.evaluation import CUT_OFF, METHOD, Discharge
from apesim.studies.discharge.vessel import Vessel
from apesim.studies.terminal.tables import table_of


def discharge_json(result: Discharge, vessel: Vessel) -> dict[str, Any]:
    """Lay out the result of discharge tests for JSON: the keys of ``apesim valve discharge --json`` that the tests say.

    A key names its unit.
    """
    rows = zip(result.records, result.fits, result.ends, result.noise, strict=True)
    return {
        "effective_area_mm2": result.full_area * 1e6,
        "effective_area_half_band_mm2": result.full_area_half_band * 1e6,
        "opens_ms": result.curve[0, 0] * 1e3 if len(result.curve) else nan,
        "open_ms": result.curve[-1, 0] * 1e3 if len(result.curve) else nan,
        "cut_off_ms": result.end * 1e3,
        "cut_off_rule": CUT_OFF,
        "method": METHOD,
        "no_curve": result.refusal or None,
        "heat": find_heat(result, vessel),
        "wall": {
            "conductance_W_K": result.wall.conductance,
            "half_band_W_K": result.wall.half_band,
            "adiabatic_area_mm2": result.wall.adiabatic_area * 1e6,
        }
        if result.wall
        else None,
        "volume_m3": vessel.volume,
        "temperature_K": vessel.temperature,
        "ambient_pressure_Pa": vessel.ambient_pressure,
        "tests": [
            {
                "file": record.name,
                "initial_pressure_Pa": record.pressures[record.times <= 0.0].mean(),
                "noise_Pa": noise,
                "cut_off_ms": end * 1e3,
                "largest_half_band_mm2": fit.half_band[fit.knots <= end].max() * 1e6,
            }
            for record, fit, end, noise in rows
        ],
        "collapse": result.collapse._asdict() if result.collapse else None,
    }


def find_heat(result: Discharge, vessel: Vessel) -> str:
    """Find how the heat from the wall was taken into account.

    The result is ``isothermal``, as the vessel was stated; ``wall``, where a conductance was found; else ``adiabatic``.
    """
    if vessel.wall == inf:
        return "isothermal"
    return "wall" if result.wall and result.wall.is_identified else "adiabatic"


def _heat_line(result: Discharge, heat: str) -> str:
    """What is said of the heat from the wall."""
    wall = result.wall
    if heat == "isothermal":
        return "heat: isothermal, as stated: the vessel keeps its temperature"
    if not wall:
        return "heat: taken as adiabatic; the choked part is too short to tell heat from the wall"
    if heat == "wall":
        conductance = f"{wall.conductance:.3g} ± {wall.half_band:.2g} W/K"
        return f"heat: the wall gives {conductance}; without it the area would seem {1e6 * wall.adiabatic_area:.4g} mm2"
    limit = wall.conductance + wall.half_band
    change = wall.area_per_conductance * limit / wall.area
    return f"heat: taken as adiabatic; up to {limit:.2g} W/K would not be seen, and change the area by {change:+.2%}"


def discharge_lines(result: Discharge, data: dict[str, Any]) -> Iterator[Table | str]:
    """Yield a table of discharge tests, and what they say in words, for `Console.result` to show one below the other.

    `data` is that of `discharge_json`, with ``curve``, the path of the curve, and ``figures``, the paths of the
    figures.
    """
    rows = [
        (
            test["file"],
            f"{test['initial_pressure_Pa'] / 1e3:.4g}",
            f"{test['noise_Pa'] / 1e3:.3g}",
            f"{test['cut_off_ms']:.3g}",
            f"{test['largest_half_band_mm2']:.2g}",
        )
        for test in data["tests"]
    ]
    header = ("test", "p_ini [kPa abs]", "noise [kPa]", "used until [ms]", "largest half band [mm2]")
    yield table_of("Discharge tests", header, rows)

    # The area of the open valve; a refusal takes the place of its numbers, which are NaN then.
    area, half = data["effective_area_mm2"], data["effective_area_half_band_mm2"]
    if result.refusal:
        yield result.refusal
    else:
        noise_alone = "" if data["heat"] == "wall" else ", by noise alone"
        yield f"effective area {area:.4g} ± {half:.2g} mm2 (95 %{noise_alone})"
        opens, is_open, end = (data[key] for key in ("opens_ms", "open_ms", "cut_off_ms"))
        yield f"opens after {opens:.3g} ms, open at {is_open:.3g} ms, reported until {end:.3g} ms"

    # What the area rests on: the heat from the wall, the agreement of the tests, and where they are cut off.
    yield _heat_line(result, data["heat"])
    collapse = result.collapse
    if collapse:
        yield (
            f"the curves {'agree' if collapse.agree else 'do not agree'}: rms {collapse.rms:.2%} of the full area, "
            f"largest spread {collapse.largest_spread:.2%}, by noise alone up to {collapse.expected_spread:.2%}; "
            f"{collapse.within_bands:.0%} of points within their bands"
        )
    yield f"cut-off: {data['cut_off_rule']}"

    # The options that run the valve with the curve, as far as there is one.
    if not result.refusal:
        yield f"{data['curve']}: use with --set valve.solenoid.opening_curve={data['curve']}"
        yield f"and --set 'valve.solenoid.effective_area={area:.5g} mm^2'"
    if data["figures"]:
        yield f"figures in {Path(data['figures'][0]).parent}/"
