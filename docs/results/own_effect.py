"""A late release in data of the independent simulator, searched with and without the file that a user wrote for it."""

from pathlib import Path
from tempfile import TemporaryDirectory

import apesim
from docs.results import Table
from docs.results.worked_cases import describe
from tests.late_release import ALIKE, APART, FILE, LEFT_OUT, write_rig

LONG = True
INPUTS = [str(FILE.relative_to(Path(__file__).parent.parent.parent))]
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
                others = [f"`{name}`" for name in found.to_dict()["class"][1:]]
                rest = f"; not distinguishable: {', '.join(others)}" if others else ""
                rows.append([pulses, f"{late:g} ms", given, f"`{found.verdict}`", describe(found) + rest])
    return {"cases": Table(["pulses", "hidden", "with the file", "verdict", "found, with 95 % interval"], rows)}
