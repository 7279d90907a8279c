"""How often a statement like this one was right on sealed cases: the probabilities that an explanation states.

A weight of models says how far the data speak for an effect, if the truth is among the models and the noise is what it
was taken for. Neither is ever quite so. What is stated is therefore the share of such statements that were right on
sealed cases of an independent simulator: a logistic regression on what is known when the statement is made. Its
coefficients are read from ``reliability.json``, which `python -m tests.truth calibrate` writes. A kind with few
statements there leans on the others; one without any, or data of another kind than theirs, has no probability.
"""

import json
from collections.abc import Iterable
from enum import StrEnum
from functools import cache
from importlib.resources import files
from math import asinh, exp, log10
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from apesim.studies.estimation.noise.discrepancy import list_discrepancies
from apesim.studies.gap.decide.inclusion import MIN_LISTED, Inclusion, find_inclusions
from apesim.studies.gap.reasons import Verdict

if TYPE_CHECKING:
    from apesim.studies.gap.explanation import Explanation

FILE = "reliability.json"
MIN_CHANCE = 1e-6
"""Chance of noise alone below which it makes no difference how small it is: it is counted from some hundred draws."""


class StatementKind(StrEnum):
    """What a statement claims."""

    EFFECT = "effect"
    """An effect, or one of several that do the same, is part of what is missing."""
    NAME = "name"
    """What is named is all that is missing."""
    CALIBRATION = "calibration"
    """A number of the machine or a reading is wrong, and nothing is missing."""
    MEASUREMENT = "measurement"
    """The record of one file is wrong, in the way that is said."""
    NO_GAP = "no gap"
    """Nothing is missing that could be seen."""
    REFUSAL = "refusal"
    """What is missing is not in the library."""


KINDS = {
    Verdict.NAMED: StatementKind.NAME,
    Verdict.NAMED_CLASS: StatementKind.NAME,
    Verdict.TWO_EFFECTS: StatementKind.NAME,
    Verdict.SEVERAL: StatementKind.NAME,
    Verdict.CALIBRATION: StatementKind.CALIBRATION,
    Verdict.MEASUREMENT: StatementKind.MEASUREMENT,
    Verdict.NO_GAP: StatementKind.NO_GAP,
    Verdict.REFUSED: StatementKind.REFUSAL,
}
"""Kind of what each verdict claims; AMBIGUOUS claims nothing."""
DENYING = StatementKind.NO_GAP, StatementKind.REFUSAL
"""Kinds of statements by which no effect of the library is there: the surest effect speaks against them."""
FEATURES = "evidence", "shortfall", "pull", "has_rivals"
"""Fields of a statement that its probability depends on."""


class Statement(NamedTuple):
    """A claim, and what is known when it is made."""

    kind: StatementKind
    about: tuple[str, ...]
    """Effects that it is about."""
    bench: str
    """Bench that the data are of."""
    evidence: float
    """Inverse hyperbolic sine of the log odds that the data give it: nearly linear up to 1, logarithmic beyond."""
    shortfall: float
    """Decimal logarithm of one over the chance of noise alone to leave as much as the best model does."""
    pull: float
    """Largest pull of a calibrated number of the machine [standard deviations of its prior]."""
    has_rivals: bool
    """Whether the data do not distinguish the best explanation from others."""
    is_counted: bool = True
    """Whether sealed cases tell of it: of effects of a machine, by a model that is taken to be exact."""


def list_statements(explanation: "Explanation") -> list[Statement]:
    """List what an explanation claims: its verdict, and that each effect is, or is not, part of what is missing.

    That of the verdict comes first, but for `AMBIGUOUS`, which claims nothing.
    """
    inclusions = find_inclusions(explanation.calibrated, explanation.ranked, explanation.foreseen)
    pulls = np.abs(explanation.best.fitted.x[explanation.best.residuals.known])
    known: dict[str, Any] = {
        "bench": explanation.measured.bench,
        "shortfall": -log10(max(explanation.left_p_value, MIN_CHANCE)),
        "pull": float(pulls.max(initial=0.0)),
        "has_rivals": bool(explanation.decision.rivals),
    }

    # Of a model that may be off and of numbers of the machine file no sealed case tells.
    is_exact = not list_discrepancies(explanation.noise)
    fitted = (candidate for choice in explanation.ranked for candidate in choice.model.candidates)
    others = (candidate for each in explanation.foreseen for candidate in each.candidates)
    numbers = {candidate.name for candidate in (*fitted, *others) if candidate.is_file_number}

    def state(kind: StatementKind, about: tuple[str, ...], evidence: float, named: Iterable[str]) -> Statement:
        return Statement(kind, about, evidence=evidence, is_counted=is_exact and not numbers & set(named), **known)

    statements = [
        state(StatementKind.EFFECT, each.names, asinh(each.log_odds), each.names)
        for each in inclusions
        if each.log_odds > MIN_LISTED
    ]
    kind, named = KINDS.get(explanation.verdict), _list_named(explanation)
    if kind is None:
        return statements
    about = named if kind in (StatementKind.NAME, StatementKind.MEASUREMENT) else ()
    return [state(kind, about, _find_evidence(kind, about, inclusions), named), *statements]


def _list_named(explanation: "Explanation") -> tuple[str, ...]:
    best = explanation.decision.best
    return best.names if best else ()


def _find_evidence(kind: StatementKind, about: tuple[str, ...], inclusions: list[Inclusion]) -> float:
    """The log odds of the least sure effect that is named, or those of the surest one, where all are denied."""
    if kind in DENYING:
        return asinh(max((each.log_odds for each in inclusions), default=0.0))
    return asinh(min((each.log_odds for each in inclusions if set(each.names) & set(about)), default=0.0))


def find_probability(statement: Statement) -> float | None:
    """Find how probable a statement is, by the share of such statements that were right on sealed cases.

    It is ``1 / (1 + exp(-(a + b + c_1 f_1 + ...)))`` with the features f of the statement, the offset a and the slopes
    c of its kind, and the offset b of its bench (logistic recalibration: Platt 1999, in Advances in Large Margin
    Classifiers, MIT Press, pp. 61-74; Cox 1958, doi 10.1093/biomet/45.3-4.562). None: no sealed cases tell of it.
    """
    told = load_reliability()
    kind, bench = told["kinds"].get(statement.kind), told["benches"].get(statement.bench)
    if kind is None or bench is None or not statement.is_counted:
        return None
    slopes = kind["slopes"]
    score = kind["offset"] + bench["offset"] + sum(slopes[name] * getattr(statement, name) for name in FEATURES)
    return 1.0 / (1.0 + exp(-score))


@cache
def load_reliability() -> dict[str, Any]:
    """Load what sealed cases tell of the probabilities of statements.

    It has ``kinds``, by kind of statement its ``offset`` and its ``slopes`` by feature, how many ``statements`` were
    made and how many were ``right``; ``benches``, by bench its ``offset`` and how many ``cases`` and ``statements`` are
    of it; ``spreads``, by which kinds and benches lean on one another, the standard deviations of the priors; and
    ``cases``, the sealed cases that were counted.
    """
    return json.loads(files(__package__).joinpath(FILE).read_text(encoding="utf-8"))


def describe_inclusion(statements: list[Statement]) -> dict[str, float | None]:
    """The probability of each effect to be part of what is missing, by its name, those like it behind an "or".

    None: no sealed cases tell of such effects.
    """
    effects = (each for each in statements if each.kind is StatementKind.EFFECT)
    return {" or ".join(each.about): find_probability(each) for each in effects}
