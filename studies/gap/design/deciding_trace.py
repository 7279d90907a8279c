"""The one trace that would tell most beside means of an engine over its speed."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from apesim.studies.estimation.residuals import unless_ended
from apesim.studies.estimation.scatter import find_stated_sizes
from apesim.studies.gap.design.experiments import Experiment, list_experiments
from apesim.studies.gap.design.isolability import add_experiment, compare_with_class
from apesim.studies.gap.reasons import NAMING, Verdict
from apesim.studies.gap.search.detection_limits import find_detection_limits, select_clearest
from apesim.studies.gap.search.library import list_effects
from apesim.studies.gap.thresholds import ALIKE
from apesim.studies.measured.prediction import MEANS

if TYPE_CHECKING:
    from apesim.studies.gap.explanation import Explanation

MIN_HINT = 3.0
"""Sigmas of a score from which on the data point to an effect, be it named or not: of some forty scores noise alone
gives so large a one in a tenth of all data sets."""


def find_deciding_trace(explanation: "Explanation", test: Mapping[str, Any]) -> dict[str, Any] | None:
    """Find the one trace that would tell most, recorded at one of the operating points; None where none would help.

    Where explanations are open, it is the one that settles most of them by `test`, the next test. Else it is the one
    with which most effects would be seen, and distinguished, that these data hide or do not distinguish; those to which
    the data point count first. ``text`` says what to record, ``sensors`` with what; ``settled`` is its share of what is
    open (None: nothing is), ``shown`` are the effects that it would show, ``hinted`` those of them to which the data
    point, and ``unclear`` all that these data leave unclear.
    """
    rows = [row for row in test.get("experiments", ()) if _is_trace(row["added_sensors"])]
    if rows and rows[0]["settled"] > 0.0:
        best = max(rows, key=lambda row: row["settled"])
        return _describe(best["text"], best["added_sensors"]) | {"settled": best["settled"]}
    shown, unclear = _find_shown(explanation)
    # What is named has explained the scores of others, too; a number that is pulled far may stand for an effect.
    is_named = explanation.decision.verdict in NAMING - {Verdict.CALIBRATION}
    hinted = [] if is_named else [score.name for score in explanation.scores if score.n_sigma > MIN_HINT]

    def value(row: tuple[Experiment, list[str]]) -> tuple[int, int]:
        return len(set(hinted) & set(row[1])), len(row[1])

    experiment, names = max(shown, key=value, default=(None, []))
    if experiment is None or not names:
        return None
    pointed = [name for name in hinted if name in names]
    return _describe(experiment.text, experiment.added) | {"shown": names, "hinted": pointed, "unclear": unclear}


def _is_trace(sensors: Any) -> bool:
    """Whether new sensors give traces, and no means alone."""
    return bool(set(sensors) - set(MEANS))


def _describe(text: str, sensors: Any) -> dict[str, Any]:
    """A trace to be recorded, with nothing said of what it would tell."""
    return {"text": text, "sensors": list(sensors), "settled": None, "shown": [], "hinted": [], "unclear": []}


def _find_shown(explanation: "Explanation") -> tuple[list[tuple[Experiment, list[str]]], list[str]]:
    """The effects that each experiment with a new trace would show and distinguish, and all that are unclear now."""
    measured, calibrated = explanation.measured, explanation.calibrated
    residuals, x, n = calibrated.residuals, calibrated.fitted.x, len(calibrated.fitted.data_residuals)

    # Unclear is what the data show at no size, or do not distinguish from others.
    effects = list_effects(residuals.machine)
    best = {name: own for name, own in select_clearest(explanation.sensitivities).items() if name in effects}
    limits = find_detection_limits(list(best.values()))
    classes = {name: limit["class"] for name, limit in limits.items() if limit["limit"] is not None}
    unclear = [name for name in best if name not in classes or classes[name]]
    probes = {name: (own.probe, own.effect[:n]) for name, own in best.items()}

    # Each trace is simulated once for all of these effects; one that ends early shows none.
    stated = find_stated_sizes(residuals.machine, measured, residuals.parameters)
    shown = []
    for experiment in list_experiments(measured, residuals.machine.ambient.pressure):
        if not _is_trace(experiment.added):
            continue
        changes = unless_ended(add_experiment, experiment, residuals, x, calibrated.fitted.jacobian[:n], probes, stated)
        if changes is None:
            continue
        outcomes = {name: compare_with_class(name, changes, classes.get(name, ()), best) for name in unclear}
        seen = [name for name, (alike, size) in outcomes.items() if alike <= ALIKE and size <= 1.0]
        shown.append((experiment, seen))
    return shown, unclear
