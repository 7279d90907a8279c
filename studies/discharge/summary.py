"""Discharge tests as a table on the terminal and as JSON."""

from collections.abc import Iterator
from pathlib import Path

from rich.table import Table

from apesim.studies.discharge.evaluation import CUT_OFF, METHOD, Discharge
from apesim.studies.discharge.vessel import Vessel
from apesim.studies.tables import table_of


def discharge_json(found: Discharge, vessel: Vessel) -> dict:
    """The result of discharge tests, for JSON."""
    rows = zip(found.records, found.fits, found.ends, found.noise, strict=True)
    return {
        "effective_area_mm2": found.full_area * 1e6,
        "effective_area_half_band_mm2": found.full_area_half_band * 1e6,
        "opens_ms": found.curve[0, 0] * 1e3,
        "open_ms": found.curve[-1, 0] * 1e3,
        "cut_off_ms": found.end * 1e3,
        "cut_off_rule": CUT_OFF,
        "method": METHOD,
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
        "collapse": found.collapse._asdict() if found.collapse else None,
    }


def discharge_lines(found: Discharge, data: dict) -> Iterator[Table | str]:
    """A table of discharge tests, and what they say in words."""
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
    header = ("test", "p_ini [kPa abs]", "noise [kPa]", "tells until [ms]", "largest half band [mm2]")
    yield table_of("Discharge tests", header, rows)
    area, half = data["effective_area_mm2"], data["effective_area_half_band_mm2"]
    yield f"effective area {area:.4g} ± {half:.2g} mm2 (95 %, by noise alone)"
    opens, is_open, end = (data[key] for key in ("opens_ms", "open_ms", "cut_off_ms"))
    yield f"opens after {opens:.3g} ms, open at {is_open:.3g} ms, told until {end:.3g} ms"
    collapse = found.collapse
    if collapse:
        yield (
            f"the curves {'agree' if collapse.agree else 'do not agree'}: rms {collapse.rms:.2%} of the full area, "
            f"largest spread {collapse.largest_spread:.2%}, by noise alone up to {collapse.expected_spread:.2%}; "
            f"{collapse.within_bands:.0%} of points within their bands"
        )
    yield f"cut-off: {data['cut_off_rule']}"
    yield f"{data['curve']}: use with --set valve.solenoid.opening_curve={data['curve']}"
    yield f"and --set 'valve.solenoid.effective_area={area:.5g} mm^2'"
    if data["figures"]:
        yield f"figures in {Path(data['figures'][0]).parent}/"
