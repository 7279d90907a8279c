"""Energy of a gap by signal and phase: the phases are those of the calibrated machine."""

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.estimation.calibration import calibrate
from apesim.studies.gap.search.calibrated_gap import check_against_noise
from apesim.studies.gap.search.localisation import localise
from apesim.studies.gap.search.phases import Phase
from apesim.studies.measured import read_measured
from tests.studies.gap.conftest import AMBIENT
from tests.truth.simulator.valve import Bench


def test_a_gap_is_where_it_is_in_the_measured_stroke_not_in_that_of_the_machine_file(measure):
    """A valve that rebounds, and has less friction, so that it lands milliseconds before the file says so."""
    folder = measure(Bench(restitution=0.6, viscous_friction=75.0), chambers=False)
    calibrated, _ = calibrate(Machine(), read_measured(folder, AMBIENT))
    gap = check_against_noise(calibrated, [], [])
    by_file = calibrated.residuals.marks(np.zeros(len(calibrated.fitted.x)))
    assert gap.marks[0]["opening_contact"] < by_file[0]["opening_contact"] - 1e-3
    shares = {}
    for name, marks in (("calibrated", gap.marks), ("file", by_file)):
        cells = localise(calibrated.residuals, marks, calibrated.fitted.data_residuals, holds_noise=True)
        shares[name] = sum(cell.share for cell in cells if cell.phase == Phase.IMPACT)
    assert shares["calibrated"] > 0.9 > 2.0 * shares["file"]
