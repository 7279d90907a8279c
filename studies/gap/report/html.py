"""The report of `apesim gap explain`: one page that stands alone."""

import base64
from importlib.metadata import version
from typing import NamedTuple

import jinja2
import numpy as np

from apesim.studies.gap.decide.operating_points import label_of
from apesim.studies.gap.report.comparison import shown_of, size_of
from apesim.studies.gap.report.effect_rows import interval_text, value_text
from apesim.studies.gap.report.template import TEMPLATE
from apesim.studies.gap.search.library import library
from apesim.studies.measured import CHECK, GATE

CANDIDATES = 12
"""Candidates that are shown."""
EXPLANATIONS = 8
"""Models that are shown."""
PULL = 2.0
"""Prior deviations from which a pull is marked."""


class Tried(NamedTuple):
    """What was expected of a candidate, and what came."""

    name: str
    expected: float
    """Part of the gap that its score promises [deviations]."""
    realised: float | None
    """What fitting it alone took away; None: it was not fitted."""


def tried(explanation):
    """The candidates with the highest scores, and the others that were fitted alone; the highest score first.

    Parameters
    ----------
    explanation : apesim.studies.gap.explanation.Explanation

    Returns
    -------
    list of Tried
    """
    fitted = {
        choice.names[0]: gained(explanation, choice.model) for choice in explanation.fits if len(choice.names) == 1
    }
    rows = [Tried(score.name, score.deviations, fitted.get(score.name)) for score in explanation.scores]
    return [row for place, row in enumerate(rows) if place < CANDIDATES or row.realised is not None]


def added_to(explanation):
    """What the second of two models has that the first has not, in words."""
    model = explanation.best
    if model.released:
        return f"with {key_of(model.released)} corrected"
    return f"with {' and '.join(map(words, model.names))}"


def number(value, unit=""):
    """A number as text with three significant digits, and the unit if there is one.

    Parameters
    ----------
    value : float or None
    unit : str

    Returns
    -------
    str
        "-" where there is no number.

    Examples
    --------
    >>> number(0.12345, "mm^2"), number(None)
    ('0.123 mm²', '-')
    """
    return "-" if value is None else f"{value:.3g} {raised(unit)}".rstrip()


def chance(p_value):
    """A chance as text, with two digits; below 1 in 10 000 only that is said.

    Parameters
    ----------
    p_value : float

    Returns
    -------
    str

    Examples
    --------
    >>> chance(0.0312), chance(3e-6)
    ('0.031', 'below 0.0001')
    """
    return "below 0.0001" if p_value < 1e-4 else f"{p_value:.2g}"


def page(explanation, data, compared, figures):
    """The page as HTML.

    Parameters
    ----------
    explanation : apesim.studies.gap.explanation.Explanation
    data : dict
        Content of ``verdict.json``, with ``next_test`` and ``lineage``.
    compared : list of apesim.studies.gap.report.comparison.Compared
    figures : dict of str
        SVG by name.

    Returns
    -------
    str
        HTML; the same text each time, as no time or date is in it.
    """
    ambient = explanation.calibrated.residuals.machine.ambient.pressure
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"number": number, "chance": chance, "words": words, "unit": raised, "key": key_of}
    environment.filters |= {"value": value_text, "interval": interval_text}
    ranges = {entry.name: entry.parameters[0].range for entry in library(explanation.calibrated.residuals.machine)}
    limits = [{"effect": name} | limit for name, limit in data["detection_limits"].items()]
    return environment.from_string(TEMPLATE).render(
        data=data,
        figures={name: base64.b64encode(text.encode()).decode() for name, text in figures.items()},
        unseen=any(one.role == CHECK for one in compared),
        check=unseen(compared),
        added=added_to(explanation) if compared[0].left_after is not None else "",
        visible=sorted((row for row in limits if row["limit"] is not None), key=lambda row: row["effect"]),
        hidden=sorted((row | {"range": ranges[row["effect"]]} for row in limits if row["limit"] is None), key=_name),
        means=[(label_of(one.block.run, ambient), shown_of(one.block), one) for one in compared if one.is_mean],
        runs=len(explanation.measured.runs),
        sensors=list(dict.fromkeys(one.block.sensor for one in compared)),
        explanations=explanations(explanation),
        judged=bool(explanation.measured.of(GATE)),
        units={one.block.sensor: shown_of(one.block) for one in compared},
        pull=PULL,
        version=version("apesim"),
    )


def words(name):
    """A name without underscores."""
    return name.replace("_", " ")


def raised(text):
    """Powers as they are printed."""
    return text.replace("^2", "²").replace("^3", "³")


def _name(row):
    return row["effect"]


def key_of(key):
    """A key of the machine in words."""
    return words(key.removeprefix("effects.").replace(".", ", "))


def unseen(compared):
    """Root mean squares over the noise on the runs that were never used, before and after; None: there are none."""
    own = [one for one in compared if one.role == CHECK]
    if not own:
        return None
    before = size_of(one.left_before for one in own)
    return before, (size_of(one.left_after for one in own) if own[0].left_after is not None else None)


def explanations(explanation):
    """The models that were fitted, the best first.

    Returns
    -------
    list of dict
        ``names``; ``cost``, penalised, above the least, by the fitted runs; ``judged``, the same with the runs that
        judge (None: it was not judged); ``realised``, the part of the gap that it explains [deviations].
    """
    least = min((choice.cost for choice in explanation.fits), default=0.0)
    judged = {choice.names: choice.cost for choice in explanation.ranked} if explanation.measured.of(GATE) else {}
    rows = [
        {
            "names": list(choice.names),
            "cost": choice.cost - least,
            "judged": judged[choice.names] - min(judged.values()) if choice.names in judged else None,
            "realised": gained(explanation, choice.model),
        }
        for choice in explanation.fits
    ]
    return sorted(rows, key=lambda row: (row["judged"] is None, row["judged"] or 0.0, row["cost"]))[:EXPLANATIONS]


def gained(explanation, model):
    """Part of the gap that a fitted model takes away [deviations]."""
    return float(np.sqrt(max(0.0, explanation.calibrated.cost - model.cost)))
