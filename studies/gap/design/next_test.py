"""What to test next: the experiment that would split what these data leave open."""

from math import ceil

import numpy as np
from scipy.linalg import block_diag

from apesim.studies.estimation.residuals import EndedEarly
from apesim.studies.estimation.starts import starts_at
from apesim.studies.gap.design.experiments import experiments_of, residuals_of
from apesim.studies.gap.reasons import ReasonKind, Verdict
from apesim.studies.gap.search.detection_limits import detection_limits
from apesim.studies.gap.search.library import library
from apesim.studies.gap.thresholds import N_SIGMA_VISIBLE

RIVALS = 3
"""That an experiment has to split from the best."""
LOOKED_INTO = 5
"""Experiments for which everything that is uncertain is fitted anew: those in which the models differ most."""
TOLD = 3
"""Effects whose own experiment is named."""
AS_IT_IS = "the machine as it is"


def next_test(explanation):
    """The next test, as text and data.

    Parameters
    ----------
    explanation : apesim.studies.gap.explanation.Explanation

    Returns
    -------
    dict
        ``text``; ``truth`` and ``experiments`` where explanations are to be split, the best experiment first, each with
        the ``deviations`` by which each rival would miss what the truth gives; ``isolate``, the library's own
        experiment for effects.
    """
    decision = explanation.decision
    if not explanation.scores:
        return {"text": "The same again, with the library: nothing of it was tried.", "isolate": []}
    if decision.verdict in (Verdict.AMBIGUOUS, Verdict.NAMED_CLASS) or decision.reason.kind is ReasonKind.FAINT:
        return split(explanation)
    if decision.verdict == Verdict.CALIBRATION:
        key = decision.best.names[0]
        return {"text": f"Measure {key} with another instrument, or by another way.", "isolate": []}
    if decision.verdict == Verdict.REFUSED:
        names = [score.name for score in explanation.scores[:TOLD]]
        opening = "Nothing in the library will do. What comes nearest shows best by itself"
    elif decision.verdict == Verdict.NO_GAP:
        names = [name for name, limit in detection_limits(explanation.sensitivities).items() if limit["limit"] is None]
        if not names:
            return {"text": "None is due: every effect of the library would have been seen.", "isolate": []}
        opening = "None is due for what these data show. What they cannot show needs its own test"
    else:
        names, opening = list(decision.best.names), "To see it by itself"
    isolated = {entry.name: entry.isolated_by for entry in library(explanation.calibrated.residuals.machine)}
    rows = [{"effect": name, "isolated_by": isolated[name]} for name in names[:TOLD] if name in isolated]
    ways = "; ".join(f"{row['effect'].replace('_', ' ')}: {row['isolated_by']}" for row in rows)
    return {"text": f"{opening}: {ways}.", "isolate": rows}


def split(explanation):
    """The experiments that would tell the best explanation from its rivals, the best first; see `next_test`."""
    truth = explanation.decision.best.model
    rivals = [choice.model for choice in explanation.decision.rivals[:RIVALS]]
    if not rivals or explanation.decision.reason.kind is ReasonKind.FAINT:
        rivals.append(explanation.calibrated)
    rows = []
    for plain, experiment, starts in _screened(explanation, truth, rivals):
        try:
            deviations = {_name(rival): missed(experiment, truth, rival, explanation.noise, starts) for rival in rivals}
        except EndedEarly:
            continue
        rows.append(
            {
                "text": experiment.text,
                "supply_Pa_abs": experiment.run.supply,
                "pulse_s": experiment.run.pulse,
                "speed_rad_s": experiment.run.speed,
                "sensors": [*experiment.run.channels, *experiment.run.means],
                "deviations": deviations,
                "least": min(deviations.values()),
                "least_unfitted": plain,
            }
        )
    rows.sort(key=lambda row: -row["least"])
    return {"text": _advice(rows, _name(truth)), "truth": _name(truth), "experiments": rows}


def _screened(explanation, truth, rivals):
    """The experiments in which the models differ most as they are, with the periodic states found."""
    found = []
    for experiment in experiments_of(explanation.measured, truth.residuals.machine.ambient.pressure):
        starts = starts_at(truth.residuals.machine, [experiment.run], truth.residuals.parameters, truth.fitted.x)
        try:
            own = _shown(experiment, truth, explanation.noise, starts)
            plain = min(np.linalg.norm(own - _shown(experiment, rival, explanation.noise, starts)) for rival in rivals)
        except EndedEarly:
            continue
        found.append((float(plain), experiment, starts))
    return sorted(found, key=lambda row: -row[0])[:LOOKED_INTO]


def _evaluated(experiment, model, noise, starts):
    residuals = residuals_of(experiment, model.residuals.machine, model.residuals.parameters, noise, starts)
    new = len(residuals.parameters) - len(model.fitted.x)
    return residuals, np.append(model.fitted.x, np.zeros(new)), new


def _shown(experiment, model, noise, starts):
    """What a model gives in an experiment [standard deviations], shape (n,)."""
    residuals, x, _ = _evaluated(experiment, model, noise, starts)
    return residuals.whiten(residuals.predicted(x))[:, 0]


def missed(experiment, truth, rival, noise, starts):
    """The deviations by which a rival misses the truth in an experiment, all its parameters fitted anew.

    It is, to first order, the root of the least ``|d + J s|^2 + s' I s`` over shifts s of the rival's parameters. d is
    the difference of both models in the experiment, J its sensitivities, and I the information of the data so far on
    the parameters.

    Parameters
    ----------
    experiment : apesim.studies.gap.design.experiments.Experiment
    truth, rival : apesim.studies.estimation.model.Model
    noise : dict
    starts : apesim.studies.estimation.starts.Starts
        Starts of the experiment.

    Returns
    -------
    float
        [standard deviations]
    """
    residuals, x, new = _evaluated(experiment, rival, noise, starts)
    errors = residuals.at(x)
    n = len(errors) - len(x)
    slopes = residuals.jacobian(x, errors)[0][:n]
    apart = errors[:n] - _shown(experiment, truth, noise, starts)
    information = block_diag(rival.fitted.jacobian.T @ rival.fitted.jacobian, np.eye(new))
    shift = -np.linalg.lstsq(slopes.T @ slopes + information, slopes.T @ apart, rcond=None)[0]
    left = apart + slopes @ shift
    return float(np.sqrt(left @ left + shift @ information @ shift))


def _name(model):
    return " with ".join(model.names) or AS_IT_IS


def _advice(rows, truth):
    if not rows:
        return "No experiment of the list could be simulated."
    best = rows[0]
    apart = " and ".join(f"{name} by {value:.2g}" for name, value in best["deviations"].items())
    text = f"Make {best['text']}: it would tell {truth} from {apart} deviations.".replace("_", " ")
    if best["least"] >= N_SIGMA_VISIBLE:
        return text
    repeats = ceil((N_SIGMA_VISIBLE / max(best["least"], 1e-3)) ** 2)
    if repeats > 100:
        return "No run of the list, and no sensor, would split them; what comes nearest: " + text[0].lower() + text[1:]
    return f"{text} That is less than {N_SIGMA_VISIBLE:g}: repeat it about {repeats} times."
