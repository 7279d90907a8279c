"""Data of a simulated rig whose solenoids let go later than they pull in, and the effect that a user wrote for it."""

import numpy as np

from tests.folders import ROOT
from tests.truth.sealed.challenge import Case, write
from tests.truth.sealed.library import VALVE
from tests.truth.sealed.nuisances import drawn, nuisances_for
from tests.truth.sealed.observation import Laboratory
from tests.truth.sealed.setting import AMBIENT, WHITE, Noise, Point, Setting
from tests.truth.simulator.effects import EFFECTS

FILE = ROOT / "docs" / "examples" / "data" / "late_release.py"
"""The user's file."""
LEFT_OUT = "release_delay"
"""Effect of the library that does what the file does; it is left out of the search."""
ALIKE, APART = (45.0, 45.0, 45.0), (25.0, 75.0, 50.0)
"""Pulses of the runs [ms]: a clock error does the same as a late release, or something else."""


def write_rig(folder, pulses, late):
    """Write two runs to fit and one to check.

    Parameters
    ----------
    folder : path
    pulses : sequence of float
        [ms]
    late : float
        Time by which the solenoids let go late [ms].

    Returns
    -------
    path
        Folder of the data, with the machine file.
    """
    points = tuple(
        Point(role, 1e6 * gauge + AMBIENT, 287.0, 1e-3 * pulse)
        for gauge, role, pulse in zip((0.3, 0.6, 0.5), ("fit", "fit", "check"), pulses, strict=True)
    )
    setting = Setting(VALVE, "chambers", points, Noise(1.0, WHITE, 0.0, 0.0, True), 301, 0.0)
    rng = np.random.default_rng(1)
    answer = {"seed": 1, "nuisances": drawn(nuisances_for(setting.bench, setting.channels), rng)}
    write(Case(answer, (lambda rig: EFFECTS[LEFT_OUT](rig, time=1e-3 * late),), Laboratory(setting), rng), folder)
    return folder / "case"
