"""The most likely cause of a gap that is not named, and why it is not."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.gap.reasons import ReasonKind, Verdict
from apesim.studies.gap.report.rounding import format_size

if TYPE_CHECKING:
    from apesim.studies.gap.explanation import Explanation

UNNAMED = frozenset({Verdict.REFUSED, Verdict.AMBIGUOUS, Verdict.MEASUREMENT})
"""Verdicts that name nothing, or no physics."""

NOTHING_HELPS = "none of what was tried, so look at the numbers of the machine file and at the data first"
SEE_WARNINGS = "none of what was tried, so look into what the warnings say first"
"""What is said where no explanation takes a part of the gap away, without warnings and with some."""
MIN_TELLING = 0.1
"""Part of the gap's energy that a cause has to take away to be told: with less, most of the gap is something else."""


def describe_cause(explanation: "Explanation", texts: dict[str, str]) -> dict[str, Any] | None:
    """Describe the one cause that is most likely, where no effect is named; None where one is, or nothing is missing.

    It is what explains the data best of all that was fitted; where nothing was worth its place, the table that was
    added, or the channel of a file that is explained worst. `texts` say in words what the best explanation adds, by
    name. ``before`` and ``after`` are root mean squares over the noise of ``samples`` on the fitted runs, without and
    with it (``after`` is None where it cannot be added); ``why_not`` is "" where the record of a file is blamed.
    """
    decision, tabulated = explanation.decision, explanation.tabulated
    if decision.verdict not in UNNAMED:
        return None
    text, model = " with ".join(texts.values()), decision.best.model if decision.best else None
    if model and not _is_telling(explanation.calibrated, model):
        text, model = "", None
    elif decision.reason.kind is ReasonKind.ODD_REPEAT:
        text = "a fault in the record of that file, or runs that scatter more than these few repeats show"
    elif model is None and explanation.odd:
        channel = max(explanation.odd, key=lambda each: each.size)
        text = f"something that is in {channel.file} alone, in its {channel.sensor.replace('_', ' ')}"
    elif model is None and tabulated:
        text, model = f"an unknown {tabulated.balance.balance}, which the library does not have", tabulated.model
    return {
        "text": text or (SEE_WARNINGS if explanation.warnings else NOTHING_HELPS),
        "samples": len(explanation.calibrated.fitted.data_residuals),
        "before": _find_size(explanation.calibrated),
        "after": _find_size(model) if model else None,
        "why_not": "" if decision.verdict == Verdict.MEASUREMENT else str(decision.reason),
    }


def _is_telling(calibrated: Model, model: Model) -> bool:
    """Whether a model takes a part of the gap away."""
    before, after = _find_size(calibrated) ** 2, _find_size(model) ** 2
    return before - after > MIN_TELLING * max(before - 1.0, 0.0)


def _find_size(model: Model) -> float:
    """Root mean square of what a model leaves on the fitted runs, over the noise."""
    left = model.fitted.data_residuals
    return float(np.sqrt(left @ left / len(left)))


def write_hint(data: Mapping[str, Any]) -> str:
    """Write how far to trust the most likely cause that is not named; `data` is the content of ``verdict.json``."""
    return f"{'But for what is sure, this' if data['sure'] else 'This'} is a hint, not a finding."


def describe_change(cause: dict[str, Any]) -> str:
    """Write the fall of the gap that a cause of `describe_cause` would bring as a sentence.

    >>> describe_change({"before": 5.88, "after": 1.02, "samples": 900})
    'With it the gap falls from 5.88 to 1.02 times the noise (noise alone: 1.00).'
    >>> describe_change({"before": 5.88, "after": None, "samples": 900})
    'The gap is 5.88 times the noise (noise alone: 1.00).'
    """
    before, noise = format_size(cause["before"], cause["samples"]), format_size(1.0, cause["samples"])
    change = before if cause["after"] is None else f"from {before} to {format_size(cause['after'], cause['samples'])}"
    opening = "The gap is" if cause["after"] is None else "With it the gap falls"
    return f"{opening} {change} times the noise (noise alone: {noise})."
