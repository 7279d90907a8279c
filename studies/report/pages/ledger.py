"""The ledger of exergy: what becomes of what the air brings, for some runs of an archive."""

from collections.abc import Sequence

import numpy as np

from apesim.archive import Archive
from apesim.engine.exergy import ENTERS, LEAVES
from apesim.studies.report.figures.bars import Bars
from apesim.studies.report.figures.labels import format_number
from apesim.studies.report.sections import Section, Table

PARTS = {
    "brake work": ("brake_work",),
    "friction of the engine": ("engine_friction",),
    "groove": ("groove",),
    "exhaust valves": ("exhaust_valve",),
    "exhaust air": ("exhaust_air",),
    "mixing in the cylinder": ("cylinder_mixing",),
    "feed and receiver": ("feed", "receiver_mixing"),
    "drive of the valve": ("solenoids", "chamber_mixing", "vents", "vented_air", "valve_friction", "valve_impacts"),
    "leaks and heat": ("leaks", "heat_transfer"),
}
"""Terms of the ledger that one part of a bar sums."""
WORK = "brake_work"
MIN_TERM = 1e-6
"""Least share of what enters with which a term is a row of the table."""


def describe_ledger(archive: Archive, runs: Sequence[tuple[str, int]], where: str) -> Section | None:
    """Show where exergy goes in some runs, given by label and number; None where the archive has no ledger."""
    terms = [*ENTERS, *LEAVES, "stored", "engine_friction", WORK]
    if any(f"exergy_{term}_J" not in archive.variables for term in terms):
        return None
    # Several cylinders have none: the terms are of one cylinder at constant speed.
    runs = [(label, run) for label, run in runs if np.isfinite(archive.variables[f"exergy_{WORK}_J"].values[run])]
    if not runs:
        return None
    ledgers = [
        (label, {term: float(archive.variables[f"exergy_{term}_J"].values[run]) for term in terms})
        for label, run in runs
    ]
    rows = [
        (label, {part: sum(ledger[term] for term in names) for part, names in PARTS.items()})
        for label, ledger in ledgers
    ]
    bars = Bars(
        "What becomes of the exergy in a cycle",
        "J",
        rows,
        f"At {where}, in each cycle, against the ambient; a part below zero is in the table only",
    )
    most = max(sum(abs(ledger[term]) for term in ENTERS) for _, ledger in ledgers)
    shown = [term for term in terms if any(abs(ledger[term]) > MIN_TERM * most for _, ledger in ledgers)]
    table = Table(
        "All terms of the ledger",
        ("term, J in a cycle", *(label for label, _ in ledgers)),
        [
            (
                f"{'in: ' if term in ENTERS else 'lost: ' if term in LEAVES else ''}{term.replace('_', ' ')}",
                *(format_number(ledger[term]) for _, ledger in ledgers),
            )
            for term in shown
        ],
        is_folded=True,
    )
    note = (
        "Exergy is the work that air could do at best until it is at ambient pressure and temperature. "
        "What throttles, mixes and leaves is lost; the rest is brake work."
    )
    return Section("Where the exergy goes", [bars], note, tables=[table])
