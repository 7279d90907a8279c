"""Probabilities of statements: a logistic regression on sealed cases that are apart from those that are scored."""

import json
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

FEATURES = "evidence", "shortfall", "pull"
"""What a verdict says that each of its statements rests on."""
SPREADS = (3.0, 1.0, 1.0, 1.0)
"""Standard deviations of the coefficients' priors, zero the middle: of the constant, and of each feature."""
MIN_STATEMENTS = 10
"""Statements of a kind from which there are coefficients."""


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


def fit(features, right):
    """Coefficients of the probability that a statement is right, the constant first.

    Parameters
    ----------
    features : (n, k) float array
    right : (n,) bool array

    Returns
    -------
    (1 + k,) float array
    """
    columns, signs = np.column_stack([np.ones(len(features)), features]), np.where(right, 1.0, -1.0)
    spreads = np.array(SPREADS[: columns.shape[1]])

    def price(coefficients):
        scores = signs * (columns @ coefficients)
        slopes = -signs / (1.0 + np.exp(np.clip(scores, -500.0, 500.0)))
        pulls = coefficients / spreads
        value = np.sum(np.logaddexp(0.0, -scores)) + 0.5 * pulls @ pulls
        return value, columns.T @ slopes + pulls / spreads

    return minimize(price, np.zeros(columns.shape[1]), jac=True, method="BFGS").x


def probabilities(coefficients, features):
    """Probabilities of statements, (n,) float array."""
    return 1.0 / (1.0 + np.exp(-(coefficients[0] + np.asarray(features) @ coefficients[1:])))


def calibrate(cases):
    """Coefficients by kind of statement.

    Parameters
    ----------
    cases : sequence of truth.scoring.score.Scored

    Returns
    -------
    dict
        What ``reliability.json`` holds; by kind also the Brier score of each statement by coefficients that were fitted
        without its case. Where a constant alone has a better one, the features count for nothing.
    """
    kinds = {}
    for number, case in enumerate(cases):
        for statement, right in statements_of(case):
            row = (number, [statement[name] for name in FEATURES], right)
            kinds.setdefault(statement["kind"], []).append(row)
    found = {}
    for kind, rows in sorted(kinds.items()):
        owners, features, right = (np.array(column) for column in zip(*rows, strict=True))
        found[kind] = {"statements": len(rows), "right": int(right.sum())}
        if len(rows) >= MIN_STATEMENTS:
            briers = {
                count: float(np.mean((probabilities_apart(owners, features[:, :count], right) - right) ** 2))
                for count in (0, len(FEATURES))
            }
            count = min(briers, key=briers.get)
            coefficients = [*fit(features[:, :count], right), *np.zeros(len(FEATURES) - count)]
            found[kind]["coefficients"] = [float(f"{value:.6g}") for value in coefficients]
            found[kind]["brier_apart"] = float(f"{briers[count]:.3g}")
    seeds = [case.answer["seed"] for case in cases]
    return {"cases": {"number": len(cases), "first_seed": min(seeds), "last_seed": max(seeds)}, "kinds": found}


def probabilities_apart(owners, features, right):
    """Probability of each statement by coefficients that were fitted without the statements of its case."""
    apart = np.empty(len(right))
    for owner in np.unique(owners):
        own = owners == owner
        apart[own] = probabilities(fit(features[~own], right[~own]), features[own])
    return apart


def write(found, path):
    """Write coefficients for `apesim gap explain` to read."""
    Path(path).write_text(json.dumps(found, indent=1) + "\n")
