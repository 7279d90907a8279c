"""The calibrated machine, and the test whether it leaves more of the data than noise."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.estimation.calibration import calibrate, elsewhere
from apesim.studies.estimation.levenberg_marquardt import Fitted, descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.noise.discrepancy import list_discrepancies
from apesim.studies.estimation.noise.estimation import (
    from_what_nothing_explains,
    hum_of_what_nothing_explains,
    is_known,
    may_hum,
)
from apesim.studies.estimation.noise.process import noise_for
from apesim.studies.estimation.noise.sampling import parts_of
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.estimation.scatter import Scatter
from apesim.studies.gap.input_checks import MAX_SOLVER_ERROR, find_solver_error
from apesim.studies.gap.search.candidates import Candidate
from apesim.studies.gap.search.gap_test import GapTest, compare_with_noise
from apesim.studies.gap.search.phases import find_local_shapes
from apesim.studies.gap.search.score_test import Score, Sensitivity, find_scores, find_sensitivities
from apesim.studies.gap.stage_work import Work
from apesim.studies.measured import Measured


class CalibratedGap(NamedTuple):
    """What the calibrated machine leaves of the data, and the test whether that is more than noise."""

    calibrated: Model
    sensitivities: list[Sensitivity]
    """What each effect of the library would do to the data."""
    faults: list[Sensitivity]
    """What each fault of one file would do to the data, see `apesim.studies.gap.search.run_faults`."""
    marks: list[dict[str, Any]]
    """Instants that divide each run, as the calibrated machine moves.

    See `apesim.studies.estimation.residuals.WhitenedResiduals.marks`.
    """
    scores: list[Score]
    """The best first."""
    local_shapes: np.ndarray
    """See `apesim.studies.gap.search.phases.find_local_shapes`."""
    gap_test: GapTest


def find_gap(
    machine: Machine,
    measured: Measured,
    candidates: Sequence[Candidate],
    work: Work,
    faults: Sequence[Candidate] = (),
    scatter: Scatter | None = None,
) -> tuple[CalibratedGap, float, list[str]]:
    """Calibrate a machine to measured data, and test whether it leaves more than noise; give the gap and warnings.

    The number returned with them is the simulator's own error over the noise of a sample. Where there is more than
    noise, a number is pulled far, or the fit has not converged, further starts are tried and the deepest minimum is
    taken. `faults` are those that single files may have, `scatter` is what more repeats than these have told of runs.
    Raises EndedEarly where the machine itself cannot be simulated.
    """
    work.tell("calibrating", 0, 1)
    calibrated, warnings = calibrate(machine, measured, work.simulations, scatter)
    scored = score_candidates(calibrated, candidates, work, faults)
    gap = check_against_noise(*scored)
    # A number that is pulled far may have been led astray as well: the noise that is left says nothing of that.
    is_doubtful = gap.gap_test.alarm or gap.calibrated.pulled or not gap.calibrated.fitted.converged
    deeper = elsewhere(gap.calibrated, work) if is_doubtful else gap.calibrated
    if deeper is not gap.calibrated:
        gap = check_against_noise(*score_candidates(deeper, candidates, work, faults))
    calibrated = gap.calibrated
    doubts = [] if calibrated.fitted.converged else ["the calibration did not converge"]
    solver_error = find_solver_error(calibrated.residuals, calibrated.fitted.x)
    if solver_error > MAX_SOLVER_ERROR:
        doubts.append(f"the simulator's own error is {solver_error:.2g} of the noise: it may be taken for a gap")
    return gap, solver_error, [*doubts, *warnings]


def score_candidates(
    calibrated: Model, candidates: Sequence[Candidate], work: Work, faults: Sequence[Candidate] = ()
) -> tuple[Model, list[Sensitivity], list[Sensitivity]]:
    """Find what each candidate, and each fault of a file, would do to the data; give the model and both sensitivities.

    Where what no candidate explains says more of the noise than was known, the machine is calibrated again with that,
    and the model returned is the new one.
    """
    residuals, x = calibrated.residuals, calibrated.fitted.x
    sensitivities = find_sensitivities(residuals, calibrated.fitted, candidates, work)
    of_faults = find_fault_sensitivities(residuals, calibrated.fitted, faults, work)
    known = is_known(residuals.noise)
    # What a model may be off by, where that is stated, hides what more could be told of the noise.
    if (known and not may_hum(residuals.noise)) or list_discrepancies(residuals.noise):
        return calibrated, sensitivities, of_faults
    effects = [sensitivity.effect for sensitivity in (*sensitivities, *of_faults)]
    space = find_nuisance_space(np.column_stack([calibrated.fitted.jacobian, *effects]))
    pairs = zip(residuals.by_block(space.project_out(calibrated.fitted.residuals)), residuals.blocks, strict=True)
    unexplained = [-part * noise_for(residuals.noise, block).deviation for part, block in pairs]
    if known:
        noise = hum_of_what_nothing_explains(residuals.blocks, residuals.noise, residuals.predicted(x), unexplained)
    else:
        noise = from_what_nothing_explains(
            residuals.blocks, residuals.noise, unexplained, residuals.by_block(space.base)
        )
    if noise is None:
        return calibrated, sensitivities, of_faults
    residuals = residuals.with_noise(noise)
    calibrated = Model((), residuals, descend(residuals, x, steps=calibrated.fitted.steps))
    return (
        calibrated,
        find_sensitivities(residuals, calibrated.fitted, candidates, work),
        find_fault_sensitivities(residuals, calibrated.fitted, faults, work),
    )


def find_fault_sensitivities(
    residuals: WhitenedResiduals, fitted: Fitted, faults: Sequence[Candidate], work: Work
) -> list[Sensitivity]:
    """Find what each fault of a file would do to the data.

    Faults that the sensors alone know need no new march, so they stay in this process, which remembers the last one.
    """
    sensed = [fault for fault in faults if not fault.strengths[0].is_marched]
    marched = [fault for fault in faults if fault.strengths[0].is_marched]
    residuals.at(fitted.x)
    found = find_sensitivities(residuals, fitted, sensed, Work(tell=work.tell), "scoring files")
    return found + find_sensitivities(residuals, fitted, marched, work, "scoring files")


def check_against_noise(
    calibrated: Model, sensitivities: list[Sensitivity], faults: list[Sensitivity]
) -> CalibratedGap:
    """Compare what the calibrated machine leaves with what noise alone would leave.

    `sensitivities` are those of the effects of the library, `faults` those of faults of single files.
    """
    errors, marks = calibrated.fitted.residuals, calibrated.residuals.marks(calibrated.fitted.x)
    local = find_local_shapes(calibrated.residuals, marks, find_nuisance_space(calibrated.fitted.jacobian))
    parts, spreads = parts_of(calibrated.residuals), calibrated.residuals.list_spreads()
    test = compare_with_noise([*sensitivities, *faults], local, errors, parts, spreads)
    scores = find_scores(sensitivities, errors)
    return CalibratedGap(calibrated, sensitivities, faults, marks, scores, local, test)
