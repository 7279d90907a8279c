"""Limits of the reading of measured data and discharge tests, as the code has them, and a check of a folder."""

import shutil
import tempfile
from pathlib import Path

import numpy as np

import apesim
from apesim.engine.angles import DEGREE
from apesim.studies.discharge import opening, records
from apesim.studies.estimation.noise import estimation
from apesim.studies.identify import fit, gate
from apesim.studies.measured import reading, strokes, table, thinning
from apesim.studies.measured.plausibility import thresholds
from docs.results import Number, Table
from tests.folders import ROOT

LABORATORY = ROOT / "docs" / "examples" / "data" / "laboratory"
AMBIENT = 101.325
"""Pressure of ambient air [kPa]."""


def compute():
    """Each limit that the page on measured data quotes."""
    return {
        "max_rows": Number(table.MAX_ROWS / 1e6, "million"),
        "thinned_above": Number(thinning.MAX_ROWS),
        "resolved_time": Number(1e3 * thinning.RESOLVED["time"], "ms"),
        "resolved_angle": Number(round(thinning.RESOLVED["crank_angle"] / DEGREE, 9), "°"),
        "min_rows": Number(reading.MIN_ROWS),
        "cell": Number(1e3 * strokes.CELL_LENGTH, "mm"),
        "turning": Number(1e3 * strokes.MIN_TURNING, "mm"),
        "discharge_before": Number(records.MIN_BEFORE),
        "discharge_after": Number(records.MIN_AFTER),
        "discharge_ratio": Number(records.MIN_RATIO),
        "discharge_half_band": Number(100.0 * opening.MAX_HALF_BAND, "%"),
        "fit_starts": Number(fit.STARTS),
        "gate_chance": Number(100.0 * gate.CHANCE, "%"),
        "max_masked": Number(100.0 * thresholds.MAX_MASKED, "%"),
        "max_stretch": Number(1e3 * thresholds.MAX_STRETCH["time"], "ms"),
        "of_a_mean": Number(100.0 * estimation.OF_A_MEAN, "%"),
        "resolved": Number(1e3 * thresholds.MAX_RESOLVED["time"], "ms"),
        "fine": Number(1e3 * thresholds.MAX_FINE["time"], "ms"),
        "spike_share": Number(100.0 * thresholds.MIN_SPIKE_SHARE, "%"),
        "single_share": Number(100.0 * thresholds.MIN_SINGLE_SHARE, "%"),
        "check": check_broken(),
    }


def check_broken():
    """What the check says of the gallery's data with a spike, a gauge pressure called abs, and an early trigger."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "measured")
        shutil.copytree(LABORATORY, path)
        change(path / "p016.csv", lambda rows: rows[150, 1:2].fill(25.0))
        change(path / "p040.csv", lambda rows: np.subtract(rows[:, 2], AMBIENT, out=rows[:, 2]))
        change(path / "p049.csv", lambda rows: np.add(rows[:, 0], 10.0, out=rows[:, 0]))
        check = apesim.check_measured(apesim.Machine(), path)
    rows = [[str(one.kind), one.file, f"`{one.channel}`", one.seen, one.reason, one.right] for one in check.findings]
    return Table(["", "file", "channel", "seen", "likely reason", "right"], rows)


def change(path, update):
    """Change the numbers of a CSV file in place."""
    header, _, _ = path.read_text().partition("\n")
    rows = np.loadtxt(path, delimiter=",", skiprows=1)
    update(rows)
    np.savetxt(path, rows, "%.6g", ",", header=header, comments="")
