"""Limits of the reading of measured data and discharge tests, as the code has them."""

from apesim.quantities.files import MAX_BYTES
from apesim.studies.discharge import opening, records
from apesim.studies.identify import fit, gate
from apesim.studies.measured import reading
from docs.results import Number


def compute():
    """Each limit that the page on measured data quotes."""
    return {
        "max_file": Number(MAX_BYTES / 1e6, "MB"),
        "min_rows": Number(reading.MIN_ROWS),
        "discharge_before": Number(records.MIN_BEFORE),
        "discharge_after": Number(records.MIN_AFTER),
        "discharge_ratio": Number(records.MIN_RATIO),
        "discharge_half_band": Number(100.0 * opening.MAX_HALF_BAND, "%"),
        "fit_starts": Number(fit.STARTS),
        "gate_chance": Number(100.0 * gate.CHANCE, "%"),
    }
