"""The command that turns discharge tests into an effective area."""

import time
from pathlib import Path

import numpy as np

from apesim.air import gas_of
from apesim.quantities import Culprit, InputError, Quantity, parse
from apesim.studies.commands.given import TEMPERATURE
from apesim.studies.commands.machine import load_machine
from apesim.studies.commands.tables import table_of, write_traces
from apesim.studies.console import COMMAND_LINE, DONE
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.output import refuse_to_replace

VOLUME = Quantity("cm^3", 1, 1e6, "command line", typical="500 cm^3")


def discharge_command(console, machine_file, settings, files, volume, temperature, out, overwrite=False, figures=False):
    """An opening curve from discharge tests; see `apesim valve discharge --help`.

    Parameters
    ----------
    console : apesim.studies.console.Console
    machine_file : path or None
    settings : list of str or None
        ``KEY=VALUE``
    files : sequence of path
        One for each test.
    volume : str
        Of the vessel.
    temperature : str or None
        Of its air before the valve opens; the ambient one if left out.
    out : path
        Of the curve.
    overwrite : bool
        Replace one that is there.
    figures : bool
        Draw them, into a folder beside the curve.

    Returns
    -------
    int
        Exit code.
    """
    from apesim.studies.discharge import Vessel, discharge
    from apesim.studies.discharge.evaluation import HEADER

    machine = load_machine(machine_file, settings)
    volume = parse(volume, VOLUME, where="--volume", file=COMMAND_LINE)
    given = temperature and parse(temperature, TEMPERATURE, where="--temperature", file=COMMAND_LINE)
    temperature = given or machine.ambient.temperature
    records = _read(files, machine.ambient.pressure)
    if not overwrite:
        refuse_to_replace(out)
    start = time.perf_counter()
    vessel = Vessel(volume, temperature, machine.ambient.pressure, gas_of(machine.air))
    found = call_in_thread(discharge, vessel, records).result()
    wall = time.perf_counter() - start
    write_traces(out, HEADER, found.curve * np.array([1e3, 1.0, 1e6, 1e6, 1e6]))
    drawn = _drawn(vessel, found, out.with_suffix(".figures")) if figures else []
    data = _data(found, vessel) | {
        "curve": str(out),
        "figures": [str(path) for path in drawn],
        "wall_time_s": wall,
        "warnings": found.warnings,
    }
    console.result(data, *_shown(found, data))
    for warning in found.warnings:
        console.message(f"warning: {warning}")
    return DONE


def _drawn(vessel, found, folder):
    """The figures."""
    from apesim.studies.figures.discharge import discharge_figures

    return discharge_figures(vessel, found, folder)


def _read(files, ambient_pressure):
    """The records of some files; raises `InputError` with the culprits of all of them."""
    from apesim.studies.discharge import read_test

    records, culprits = [], []
    for file in files:
        try:
            records.append(read_test(file, ambient_pressure))
        except InputError as error:
            culprits += error.culprits
    if not files:
        culprits = [Culprit(COMMAND_LINE, "FILE", "no discharge test", "give the CSV of at least one")]
    if culprits:
        raise InputError(culprits)
    return records


def _data(found, vessel):
    """The result as a dictionary."""
    from apesim.studies.discharge.evaluation import CUT_OFF, METHOD

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


def _shown(found, data):
    """A table and some lines for the terminal."""
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
