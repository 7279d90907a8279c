"""The calibrated machine, and the test whether it leaves more of the data than noise."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.estimation.calibration import calibrate, elsewhere
from apesim.studies.estimation.levenberg_marquardt import descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.noise.estimation import (
    from_what_nothing_explains,
    hum_of_what_nothing_explains,
    is_known,
    may_hum,
)
from apesim.studies.estimation.noise.process import noise_for
from apesim.studies.estimation.noise.sampling import parts_of
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.gap.input_checks import MAX_SOLVER_ERROR, find_solver_error
from apesim.studies.gap.search.candidates import Candidate
from apesim.studies.gap.search.gap_test import GapTest, compare_with_noise
from apesim.studies.gap.search.phases import find_local_shapes
from apesim.studies.gap.search.score_test import Score, Sensitivity, find_scores, find_sensitivities
from apesim.studies.gap.work import Work
from apesim.studies.measured import Measured


class CalibratedGap(NamedTuple):
    """What the calibrated machine leaves of the data, and the test whether that is more than noise."""

    calibrated: Model
    sensitivities: list[Sensitivity]
    """What each candidate would do to the data."""
    marks: list[dict[str, Any]]
    """Instants that divide each run, as the machine file says.

    See `apesim.studies.estimation.residuals.WhitenedResiduals.marks`.
    """
    scores: list[Score]
    """The best first."""
    local_shapes: np.ndarray
    """See `apesim.studies.gap.search.phases.find_local_shapes`."""
    gap_test: GapTest


def find_gap(
    machine: Machine, measured: Measured, candidates: Sequence[Candidate], work: Work
) -> tuple[CalibratedGap, float, list[str]]:
    """Calibrate a machine to measured data, and test whether it leaves more than noise.

    Where it does, further starts are tried, and the deepest minimum is taken.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    measured : apesim.studies.measured.Measured
    candidates : sequence of apesim.studies.gap.search.candidates.Candidate
        Effects that may be missing.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    gap : CalibratedGap
    solver_error : float
        The simulator's own error over the noise of a sample.
    warnings : list of str

    Raises
    ------
    apesim.studies.estimation.residuals.EndedEarly
        The machine itself cannot be simulated.

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import read_example
    >>> gap, solver_error, warnings = find_gap(Machine(), read_example(), [], Work())
    >>> gap.gap_test.alarm, solver_error < MAX_SOLVER_ERROR, warnings
    (True, True, [])
    """
    work.tell("calibrating", 0, 1)
    calibrated, warnings = calibrate(machine, measured, work.simulations)
    calibrated, sensitivities = score_candidates(calibrated, candidates, work)
    residuals = calibrated.residuals
    marks = residuals.marks(np.zeros(len(calibrated.fitted.x)))
    gap = check_against_noise(calibrated, sensitivities, marks)
    deeper = elsewhere(calibrated, work) if gap.gap_test.alarm else calibrated
    if deeper is not calibrated:
        gap = check_against_noise(*score_candidates(deeper, candidates, work), marks)
    calibrated = gap.calibrated
    if not calibrated.fitted.converged:
        warnings.append("the calibration did not converge")
    solver_error = find_solver_error(calibrated.residuals, calibrated.fitted.x)
    if solver_error > MAX_SOLVER_ERROR:
        warnings.append(f"the simulator's own error is {solver_error:.2g} of the noise: it may be taken for a gap")
    return gap, solver_error, warnings


def score_candidates(calibrated: Model, candidates: Sequence[Candidate], work: Work) -> tuple[Model, list[Sensitivity]]:
    """Find what each candidate would do to the data.

    Where what no candidate explains says more of the noise than was known, the machine is calibrated again with that.

    Parameters
    ----------
    calibrated : apesim.studies.estimation.model.Model
    candidates : sequence of apesim.studies.gap.search.candidates.Candidate
    work : apesim.studies.gap.work.Work

    Returns
    -------
    calibrated : Model
        The machine given, or the one calibrated again.
    sensitivities : list of Sensitivity

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import find_example_gap
    >>> calibrated = find_example_gap().calibrated
    >>> candidates = [sensitivity.probe.candidate for sensitivity in find_example_gap().sensitivities[:1]]
    >>> again, sensitivities = score_candidates(calibrated, candidates, Work())
    >>> again is calibrated, sensitivities[0].probe.candidate.name
    (True, 'spring_rate_error')
    """
    residuals, x = calibrated.residuals, calibrated.fitted.x
    sensitivities = find_sensitivities(residuals, calibrated.fitted, candidates, work)
    known = is_known(residuals.noise)
    if known and not may_hum(residuals.noise):
        return calibrated, sensitivities
    space = find_nuisance_space(
        np.column_stack([calibrated.fitted.jacobian, *(sensitivity.effect for sensitivity in sensitivities)])
    )
    pairs = zip(residuals.by_block(space.project_out(calibrated.fitted.residuals)), residuals.blocks, strict=True)
    unexplained = [-part * noise_for(residuals.noise, block).deviation for part, block in pairs]
    if known:
        noise = hum_of_what_nothing_explains(residuals.blocks, residuals.noise, residuals.predicted(x), unexplained)
    else:
        noise = from_what_nothing_explains(
            residuals.blocks, residuals.noise, unexplained, residuals.by_block(space.base)
        )
    if noise is None:
        return calibrated, sensitivities
    residuals = residuals.with_noise(noise)
    calibrated = Model((), residuals, descend(residuals, x, steps=calibrated.fitted.steps))
    return calibrated, find_sensitivities(residuals, calibrated.fitted, candidates, work)


def check_against_noise(
    calibrated: Model, sensitivities: list[Sensitivity], marks: list[dict[str, Any]]
) -> CalibratedGap:
    """Compare what the calibrated machine leaves with what noise alone would leave.

    Parameters
    ----------
    calibrated : apesim.studies.estimation.model.Model
    sensitivities : list of apesim.studies.gap.search.score_test.Sensitivity
    marks : list of dict
        Instants that divide each run.

    Returns
    -------
    CalibratedGap

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import find_example_gap
    >>> gap = find_example_gap()
    >>> again = check_against_noise(gap.calibrated, gap.sensitivities, gap.marks)
    >>> again.scores[0].name, again.gap_test.alarm
    ('side_force', True)
    """
    errors = calibrated.fitted.residuals
    local = find_local_shapes(calibrated.residuals, marks, find_nuisance_space(calibrated.fitted.jacobian))
    test = compare_with_noise(sensitivities, local, errors, parts_of(calibrated.residuals))
    return CalibratedGap(calibrated, sensitivities, marks, find_scores(sensitivities, errors), local, test)
