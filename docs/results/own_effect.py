"""A late release in data of the independent simulator, searched with and without the file that a user wrote for it."""

from pathlib import Path
from tempfile import TemporaryDirectory

import apesim
from apesim.studies.gap.report.effect_rows import format_interval, format_value
from docs.results import Table
from tests.late_release import ALIKE, APART, FILE, LEFT_OUT, write_rig

LONG = True
CASES = {"25 and 75 ms": (APART, 0.8), "45 ms, all alike": (ALIKE, 0.3)}
"""Pulses of the runs and the time by which the solenoids let go late [ms], by the words of the page."""


def compute():
    """What is said of each set of data, without the file and with it."""
    rows = []
    for pulses, (lengths, late) in CASES.items():
        with TemporaryDirectory() as name:
            folder = write_rig(Path(name), lengths, late)
            machine = apesim.Machine.load(folder / "machine.toml")
            for given, tried in (("no", machine), ("yes", machine.with_effects(FILE))):
                found = apesim.explain(tried, folder, without=[LEFT_OUT])
                rows.append([pulses, f"{late:g} ms", given, f"`{found.verdict}`", describe(found)])
    return {"cases": Table(["pulses", "hidden", "with the file", "verdict", "found"], rows)}


def describe(found):
    """What is named, with its interval, and what the data do not distinguish from it."""
    texts = [
        f"`{row['key'].removeprefix('effects.')}` {format_value(row)} ({format_interval(row)})" for row in found.effects
    ]
    others = [" with ".join(f"`{name}`" for name in other["effects"]) for other in found.alternatives]
    return "; not distinguishable from it: ".join(filter(None, ["; ".join(texts) or "nothing", ", ".join(others)]))
