"""Probabilities of statements: one logistic regression on sealed cases that are apart from those that are scored.

Kinds of statements and benches lean on one another (partial pooling): each has an offset of its own, and each kind has
slopes of its own, as far as its statements tell so; where they are few, it has those of all.
"""

import json
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from tests.truth.sealed.library import ENGINE, VALVE

from .figures import brier
from .forecasts import judge
from .tables import between, markdown

FEATURES = "evidence", "shortfall", "pull", "has_rivals"
"""What a verdict says that each of its statements rests on."""
NAMING = (1, -1, -1, -1)
DIRECTIONS = {
    "effect": NAMING,
    "name": NAMING,
    "measurement": NAMING,
    "calibration": (1, -1, 1, -1),
    "no gap": (-1, -1, -1, 0),
    "refusal": (-1, 1, 0, 0),
}
"""Directions of the features by kind: each can only raise the probability (1), or lower it (-1), or says nothing (0).

Evidence for an effect speaks for its name, and against a statement that none is there. What the best model leaves
speaks against what is named, and for a refusal. A pull is what a calibration rests on; an effect or a name may have
been taken up by it, and of a refusal it says nothing.
"""
KINDS, BENCHES = (*DIRECTIONS,), (VALVE, ENGINE)
"""Order of kinds and benches in what is fitted."""
SIGNS = np.array([*DIRECTIONS.values()], dtype=float)
"""Directions, a row for each kind."""
FREE = 3.0
"""Standard deviation of the prior of the offset that is common to all statements: nearly all shares may be so."""
USUAL = 0.3
"""Middle of the prior of a slope: a feature that is one standard deviation off moves even odds to 4 : 3."""
STEEPEST, FLATTEST = 20.0, 1e-3
"""Ends of a slope, beyond which it makes no difference."""
SPREADS = {
    "common_slopes": (0.3, 1.0, 2.0),
    "slopes": (0.1, 0.3, 1.0),
    "kinds": (0.3, 1.0, 3.0),
    "benches": (0.1, 0.5),
}
"""Standard deviations that are tried for priors: of the logarithm of slopes that are common to all kinds, and of how
far logarithms of slopes of kinds, offsets of kinds and offsets of benches differ from what is common."""
FOLDS = 10
"""Parts of the cases, each foretold by the others, by which the spreads are chosen."""
DIGITS = 6
"""Digits of coefficients that are written."""


class Statements(NamedTuple):
    """Statements with what is known of them, a row each."""

    owners: np.ndarray
    """Number of the case."""
    kinds: np.ndarray
    benches: np.ndarray
    features: np.ndarray
    right: np.ndarray

    def only(self, which):
        """Some of the statements."""
        return Statements(*(column[which] for column in self))

    @property
    def is_kind(self):
        """Whether each is of each of `KINDS`."""
        return self.kinds[:, None] == np.array(KINDS)

    @property
    def is_bench(self):
        """Whether each is of each of `BENCHES`."""
        return self.benches[:, None] == np.array(BENCHES)


class Coefficients(NamedTuple):
    """A regression; what has no statements has what is common to all."""

    kinds: np.ndarray
    """Offsets of `KINDS`."""
    benches: np.ndarray
    """Offsets of `BENCHES`."""
    slopes: np.ndarray
    """Slopes of `KINDS`, a row each, of `FEATURES`."""


def statements_of(scored):
    """Statements of a case with whether each is right.

    Parameters
    ----------
    scored : truth.scoring.score.Scored

    Yields
    ------
    dict, bool
        Of the case as a whole, and of what is said without a file that is blamed.
    """
    for statement in scored.verdict.get("statements", ()):
        if statement["kind"] != "effect":
            if scored.right is not None:
                yield statement, bool(scored.right)
            continue
        yield statement, scored.is_there(statement["about"])
    for statement in (scored.verdict.get("rest") or {}).get("statements", ()):
        if statement["kind"] == "effect":
            yield statement, scored.is_there(statement["about"])


def gather(cases):
    """Statements of all cases that count: of numbers of the machine file, and of a model that is off, none does.

    Parameters
    ----------
    cases : sequence of truth.scoring.score.Scored

    Returns
    -------
    Statements

    Raises
    ------
    SystemExit
        Nothing counts, or a verdict is of a release whose statements do not say what they rest on.
    """
    said = [(number, *each) for number, case in enumerate(cases) for each in statements_of(case)]
    for number, one, _ in said:
        if absent := [name for name in ("bench", "is_counted", *FEATURES) if name not in one]:
            seed = cases[number].answer["seed"]
            raise SystemExit(f"seed {seed}: its verdict is of another release, a statement has no {', '.join(absent)}")
    rows = [
        (number, one["kind"], one["bench"], [float(one[name]) for name in FEATURES], right)
        for number, one, right in said
        if one["is_counted"]
    ]
    if not rows:
        raise SystemExit("no statement of these cases counts: a probability needs statements")
    return Statements(*(np.array(column) for column in zip(*rows, strict=True)))


def fit(statements, spreads):
    """Coefficients of the probability that a statement is right: the most probable ones by their normal priors.

    Parameters
    ----------
    statements : Statements
    spreads : dict of float
        Standard deviations by the names of `SPREADS`.

    Returns
    -------
    Coefficients
    """
    # Features in their own standard deviations from their middle, so that one prior does for all of them.
    middle, scale = statements.features.mean(axis=0), statements.features.std(axis=0)
    scale[scale == 0.0] = 1.0
    shown = (statements.features - middle) / scale
    sloped = (statements.is_kind[:, :, None] * SIGNS * shown[:, None, :]).reshape(len(shown), SIGNS.size)
    level = np.column_stack([np.ones(len(shown)), statements.is_kind, statements.is_bench])
    sides = np.where(statements.right, 1.0, -1.0)
    widths = np.repeat([FREE, spreads["kinds"], spreads["benches"]], [1, len(KINDS), len(BENCHES)])
    wide, narrow = spreads["common_slopes"], spreads["slopes"]
    places = np.cumsum([len(FEATURES), len(widths)])

    # Slopes are fitted by their logarithms, so that none vanishes or turns against its direction.
    def price(values):
        common, offsets, slopes = np.split(values, places)
        sizes, own = np.exp(slopes), (slopes.reshape(SIGNS.shape) - common) / narrow
        scores = sides * (level @ offsets + sloped @ sizes)
        pulls = -sides / (1.0 + np.exp(np.clip(scores, -500.0, 500.0)))
        shift, off = (common - np.log(USUAL)) / wide, offsets / widths
        value = np.sum(np.logaddexp(0.0, -scores)) + 0.5 * (shift @ shift + off @ off + np.sum(own**2))
        down = shift / wide - np.sum(own, axis=0) / narrow
        return value, np.concatenate(
            [down, level.T @ pulls + off / widths, sizes * (sloped.T @ pulls) + own.ravel() / narrow]
        )

    ends = (float(np.log(FLATTEST)), float(np.log(STEEPEST)))
    bounds = [ends] * len(FEATURES) + [(None, None)] * len(widths) + [ends] * SIGNS.size
    start = np.repeat([np.log(USUAL), 0.0, np.log(USUAL)], [len(FEATURES), len(widths), SIGNS.size])
    found = minimize(price, start, jac=True, method="L-BFGS-B", bounds=bounds).x
    _, offsets, slopes = np.split(found, places)
    slopes = SIGNS * np.exp(slopes).reshape(SIGNS.shape) / scale
    first, kinds, benches = np.split(offsets, [1, 1 + len(KINDS)])
    return Coefficients(first + kinds - slopes @ middle, benches, slopes)


def probabilities(coefficients, statements):
    """Probabilities of statements, (n,) float array."""
    slopes = statements.is_kind @ coefficients.slopes
    offsets = statements.is_kind @ coefficients.kinds + statements.is_bench @ coefficients.benches
    return 1.0 / (1.0 + np.exp(-(offsets + np.sum(slopes * statements.features, axis=1))))


def probabilities_apart(statements, spreads, parts):
    """Probability of each statement by coefficients that were fitted without the statements of its part."""
    apart = np.empty(len(parts))
    for part in np.unique(parts):
        own = parts == part
        apart[own] = probabilities(fit(statements.only(~own), spreads), statements.only(own))
    return apart


def log_loss(stated, right):
    """Mean of minus the logarithm of the probability that was stated for what is so."""
    return float(-np.mean(np.log(np.where(right, stated, 1.0 - stated))))


def choose_spreads(statements):
    """Spreads by which each part of the cases is foretold best by the others."""
    parts = statements.owners % FOLDS
    tried = [dict(zip(SPREADS, each, strict=True)) for each in product(*SPREADS.values())]
    return min(tried, key=lambda one: log_loss(probabilities_apart(statements, one, parts), statements.right))


def calibrate(cases):
    """What sealed cases tell of the probabilities of statements.

    Parameters
    ----------
    cases : sequence of truth.scoring.score.Scored

    Returns
    -------
    dict
        What ``reliability.json`` holds.
    str
        How good the probabilities are, a row for each kind: each case judged by coefficients without it.
    """
    statements = gather(cases)
    spreads = choose_spreads(statements)
    found = fit(statements, spreads)
    seeds = [case.answer["seed"] for case in cases]
    kinds = {
        kind: {
            "statements": int(np.sum(which)),
            "right": int(np.sum(statements.right[which])),
            "offset": write_number(offset),
            "slopes": dict(zip(FEATURES, map(write_number, slopes), strict=True)),
        }
        for kind, which, offset, slopes in zip(KINDS, statements.is_kind.T, found.kinds, found.slopes, strict=True)
        if which.any()
    }
    benches = {
        bench: {
            "cases": sum(case.answer["bench"] == bench for case in cases),
            "statements": int(np.sum(which)),
            "offset": write_number(offset),
        }
        for bench, which, offset in zip(BENCHES, statements.is_bench.T, found.benches, strict=True)
        if which.any()
    }
    stated = probabilities_apart(statements, spreads, statements.owners)
    numbers = {"number": len(cases), "first_seed": min(seeds), "last_seed": max(seeds)}
    told = {"cases": numbers, "spreads": spreads, "benches": benches, "kinds": kinds}
    return told, table(statements, stated)


def write_number(value):
    """A coefficient with `DIGITS` digits, and without the sign of a zero."""
    return float(f"{value:.{DIGITS}g}") + 0.0


def table(statements, stated):
    """How good probabilities are, by kind and by bench, as Markdown."""
    groups = {kind: statements.kinds == kind for kind in np.unique(statements.kinds)}
    groups |= {f"all, {bench}": statements.benches == bench for bench in np.unique(statements.benches)}
    rows = []
    for name, which in {**groups, "all": np.ones(len(stated), dtype=bool)}.items():
        chances, right = stated[which], statements.right[which]
        judged = judge(statements.owners[which], chances, right).values()
        numbers = (chances.mean(), brier([*zip(chances, right, strict=True)]), log_loss(chances, right))
        shown = ("–" if one.value is None else f"{one.value:.2f} ({between(one.interval)})" for one in judged)
        rows.append([name, len(right), int(right.sum()), *(f"{number:.3f}" for number in numbers), *shown])
    head = ["statements", "made", "right", "mean stated", "Brier score", "log loss"]
    return markdown([*head, "debiased calibration error", "Spiegelhalter's Z", "slope"], rows)


def write(told, path):
    """Write coefficients for `apesim gap explain` to read."""
    Path(path).write_text(json.dumps(told, indent=1) + "\n")
