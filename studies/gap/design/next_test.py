"""Next test: the experiment that would split the explanations between which these data do not decide."""

from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import block_diag

from apesim.studies.estimation.model import Model
from apesim.studies.estimation.residuals import EndedEarly, WhitenedResiduals
from apesim.studies.estimation.starts import Starts, starts_at
from apesim.studies.gap.design.experiments import Experiment, list_experiments, make_residuals
from apesim.studies.gap.reasons import ReasonKind, Verdict
from apesim.studies.gap.search.detection_limits import find_detection_limits
from apesim.studies.gap.search.library import list_effects
from apesim.studies.gap.search.run_faults import find_files
from apesim.studies.gap.thresholds import N_SIGMA_VISIBLE
from apesim.studies.measured import CYLINDER

if TYPE_CHECKING:
    from apesim.studies.gap.explanation import Explanation

MAX_RIVALS = 3
"""Rivals that an experiment has to split from the best: with more, none of the list does."""
MAX_EXPERIMENTS = 5
"""Experiments for which everything that is uncertain is fitted anew, those in which the models differ most: each costs
seconds."""
MAX_EFFECTS = 3
"""Effects whose own experiment is named: more would not be read."""
MAX_REPEATS = 100
"""Repeats of an experiment above which it is no advice."""
ISOLATED_ON_RIG = {
    "coulomb_friction": "strokes at two pressures, and at two speeds with a factor of five between them",
    "stribeck_friction": "strokes at one pressure, at speeds from 1 mm/s to some 100 mm/s",
    "seal_friction": "strokes at three pressures and one speed",
    "quadratic_drag": "strokes at one pressure, as fast as the drive can",
    "side_force": "the load cell tared with the piston free, and the rig turned over",
}
"""Experiments on a cylinder that a drive moves; those of the library are on a valve."""
AS_IT_IS = "the machine as it is"
"""Name of the calibrated machine, where it is one of the explanations."""


def find_next_test(explanation: "Explanation") -> dict[str, Any]:
    """Find the next test, as text and data.

    Parameters
    ----------
    explanation : apesim.studies.gap.explanation.Explanation

    Returns
    -------
    dict
        ``text``; ``truth`` and ``experiments`` where explanations are to be split, the best experiment first, each with
        the ``deviations`` by which each rival would miss what the truth gives; ``isolate``, the library's own
        experiment for effects.

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> find_next_test(explain_example())["isolate"][0]["effect"]
    'side_force'
    """
    decision = explanation.decision
    if not explanation.scores:
        return {"text": "The same again, with the library: nothing of it was tried.", "isolate": []}
    if decision.verdict in (Verdict.AMBIGUOUS, Verdict.NAMED_CLASS) or decision.reason.kind is ReasonKind.FAINT:
        return rank_experiments(explanation)
    if explanation.rest:
        files = " and ".join(find_files(explanation.best.candidates))
        rest = find_next_test(explanation.rest)
        return rest | {"text": f"Record {files} again, or leave it out. Then: {rest['text']}"}
    names = list(decision.best.names) if decision.best else []
    if decision.verdict == Verdict.CALIBRATION:
        key = names[0]
        return {"text": f"Measure {key} with another instrument, or by another way.", "isolate": []}
    if decision.verdict == Verdict.REFUSED:
        names = [score.name for score in explanation.scores[:MAX_EFFECTS]]
        opening = "Nothing in the library will do. What comes nearest shows best by itself"
    elif decision.verdict == Verdict.NO_GAP:
        names = [
            name for name, limit in find_detection_limits(explanation.sensitivities).items() if limit["limit"] is None
        ]
        if not names:
            return {"text": "None is due: every effect of the library would have been seen.", "isolate": []}
        opening = "None is due for what these data show. What they cannot show needs its own test"
    else:
        opening = "To see it by itself"
    isolated = {
        name: entry.isolated_by for name, entry in list_effects(explanation.calibrated.residuals.machine).items()
    }
    if explanation.measured.bench == CYLINDER:
        isolated |= ISOLATED_ON_RIG
    rows = [{"effect": name, "isolated_by": isolated[name]} for name in names[:MAX_EFFECTS] if name in isolated]
    ways = "; ".join(f"{row['effect'].replace('_', ' ')}: {row['isolated_by']}" for row in rows)
    return {"text": f"{opening}: {ways}.", "isolate": rows}


def rank_experiments(explanation: "Explanation") -> dict[str, Any]:
    """Rank the experiments that would distinguish the best explanation from its rivals.

    Parameters
    ----------
    explanation : apesim.studies.gap.explanation.Explanation
        With a best explanation.

    Returns
    -------
    dict
        ``text``, ``truth`` and ``experiments``, the best first, see `find_next_test`.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> rivals = tuple(choice for choice in explanation.fits if choice.names == ("coulomb_friction",))
    >>> ranked = rank_experiments(replace(explanation, decision=explanation.decision._replace(rivals=rivals)))
    >>> ranked["truth"], ranked["experiments"][0]["least"] > N_SIGMA_VISIBLE
    ('side_force', True)
    """
    assert explanation.decision.best is not None
    truth = explanation.decision.best.model
    rivals = [choice.model for choice in explanation.decision.rivals[:MAX_RIVALS]]
    if not rivals or explanation.decision.reason.kind is ReasonKind.FAINT:
        rivals.append(explanation.calibrated)
    rows: list[dict[str, Any]] = []
    for plain, experiment, starts in _screen_experiments(explanation, truth, rivals):
        try:
            n_sigma = {
                _name_model(rival): find_separation(experiment, truth, rival, explanation.noise, starts)
                for rival in rivals
            }
        except EndedEarly:
            continue
        rows.append(
            {
                "text": experiment.text,
                "supply_Pa_abs": experiment.run.supply,
                "pulse_s": experiment.run.pulse,
                "speed_rad_s": experiment.run.speed,
                "sensors": [*experiment.run.channels, *experiment.run.means],
                "deviations": n_sigma,
                "least": min(n_sigma.values()),
                "least_unfitted": plain,
            }
        )
    rows.sort(key=lambda row: -row["least"])
    return {"text": _write_advice(rows, _name_model(truth)), "truth": _name_model(truth), "experiments": rows}


def _screen_experiments(
    explanation: "Explanation", truth: Model, rivals: list[Model]
) -> list[tuple[float, Experiment, Starts]]:
    """The experiments in which the models differ most as they are, with the periodic states found."""
    screened = []
    for experiment in list_experiments(explanation.measured, truth.residuals.machine.ambient.pressure):
        starts = starts_at(truth.residuals.machine, [experiment.run], truth.residuals.parameters, truth.fitted.x)
        try:
            expected = _predict_whitened(experiment, truth, explanation.noise, starts)
            plain = min(
                np.linalg.norm(expected - _predict_whitened(experiment, rival, explanation.noise, starts))
                for rival in rivals
            )
        except EndedEarly:
            continue
        screened.append((float(plain), experiment, starts))
    return sorted(screened, key=lambda row: -row[0])[:MAX_EXPERIMENTS]


def _make_residuals(
    experiment: Experiment, model: Model, noise: dict[str, Any], starts: Starts
) -> tuple[WhitenedResiduals, np.ndarray, int]:
    """Residuals of an experiment, the parameters as fitted with those of new sensors at 0, and the number of these."""
    residuals = make_residuals(experiment, model.residuals.machine, model.residuals.parameters, noise, starts)
    new = len(residuals.parameters) - len(model.fitted.x)
    return residuals, np.append(model.fitted.x, np.zeros(new)), new


def _predict_whitened(experiment: Experiment, model: Model, noise: dict[str, Any], starts: Starts) -> np.ndarray:
    """Whitened prediction of an experiment by a model, (n,) [standard deviations]."""
    residuals, x, _ = _make_residuals(experiment, model, noise, starts)
    return residuals.whiten(residuals.predicted(x))[:, 0]


def find_separation(experiment: Experiment, truth: Model, rival: Model, noise: dict[str, Any], starts: Starts) -> float:
    """Find by how many sigmas a rival misses the truth in an experiment, all its parameters fitted anew.

    It is, to first order, the root of the least ``|d + J s|^2 + s' I s`` over shifts s of the rival's parameters. d is
    the difference of both models in the experiment, J its sensitivities, and I the information of the data so far on
    the parameters.

    Parameters
    ----------
    experiment : apesim.studies.gap.design.experiments.Experiment
    truth, rival : apesim.studies.estimation.model.Model
    noise : dict
        See `apesim.studies.estimation.noise.estimation.noise_of`.
    starts : apesim.studies.estimation.starts.Starts
        Starts of the experiment.

    Returns
    -------
    float
        [standard deviations]

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> experiment = list_experiments(explanation.measured, 101325.0)[0]
    >>> residuals = explanation.best.residuals
    >>> starts = starts_at(residuals.machine, [experiment.run], residuals.parameters, explanation.best.fitted.x)
    >>> find_separation(experiment, explanation.best, explanation.best, explanation.noise, starts)
    0.0
    >>> find_separation(experiment, explanation.best, explanation.calibrated, explanation.noise, starts) > 1.0
    True
    """
    residuals, x, new = _make_residuals(experiment, rival, noise, starts)
    errors = residuals.at(x)
    n = len(errors) - len(x)
    slopes = residuals.jacobian(x, errors)[0][:n]
    difference = errors[:n] - _predict_whitened(experiment, truth, noise, starts)
    information = block_diag(rival.fitted.jacobian.T @ rival.fitted.jacobian, np.eye(new))
    shift = -np.linalg.lstsq(slopes.T @ slopes + information, slopes.T @ difference, rcond=None)[0]
    missed = difference + slopes @ shift
    return float(np.sqrt(missed @ missed + shift @ information @ shift))


def _name_model(model: Model) -> str:
    """Name of an explanation, by what it adds."""
    return " with ".join(model.names) or AS_IT_IS


def _write_advice(rows: list[dict[str, Any]], truth: str) -> str:
    """Advice on the best of the experiments, in words."""
    if not rows:
        return "No experiment of the list could be simulated."
    best = rows[0]
    differences = " and ".join(f"{name} by {value:.2g}" for name, value in best["deviations"].items())
    text = f"Make {best['text']}: it would distinguish {truth} from {differences} sigmas.".replace("_", " ")
    if best["least"] >= N_SIGMA_VISIBLE:
        return text
    repeats = ceil((N_SIGMA_VISIBLE / max(best["least"], 1e-3)) ** 2)
    if repeats > MAX_REPEATS:
        return "No run of the list, and no sensor, would split them; what comes nearest: " + text[0].lower() + text[1:]
    return f"{text} That is less than {N_SIGMA_VISIBLE:g}: repeat it about {repeats} times."
