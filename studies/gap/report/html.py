"""The report of `apesim gap explain`: one page that stands alone."""

import base64
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import version
from importlib.resources import files
from typing import TYPE_CHECKING, Any, NamedTuple

import jinja2
import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.gap.decide.operating_points import label_point
from apesim.studies.gap.report.calibrated_numbers import format_after, format_before
from apesim.studies.gap.report.comparison import ComparedSignal, find_display, find_rms
from apesim.studies.gap.report.effect_rows import format_interval, format_value
from apesim.studies.gap.report.extended_machine import is_explained
from apesim.studies.gap.search.detection_limits import format_limit
from apesim.studies.gap.search.library import list_effects
from apesim.studies.measured import CHECK, GATE

if TYPE_CHECKING:
    from apesim.studies.gap.explanation import Explanation

MAX_CANDIDATES = 12
"""Candidates that are shown at most: those that are fitted alone for their score."""
MAX_EXPLANATIONS = 8
"""Models that are shown at most: more would not be read."""
MARKED_PULL = 2.0
"""Prior standard deviations beyond which a pull is marked: noise alone pulls one of twenty nuisances so far."""


class TriedCandidate(NamedTuple):
    """A candidate with the part of the gap that its score promises, and the part that its fit takes away."""

    name: str
    """Name of the effect."""
    expected: float
    """Part of the gap that its score promises [standard deviations]."""
    realised: float | None
    """Part of the gap that its fit alone takes away [standard deviations]; None: it was not fitted."""


def compare_candidates(explanation: "Explanation") -> list[TriedCandidate]:
    """The candidates with the highest scores, and the others that were fitted alone; the highest score first.

    Parameters
    ----------
    explanation : apesim.studies.gap.explanation.Explanation

    Returns
    -------
    list of TriedCandidate

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> compare_candidates(explain_example())[0].name
    'side_force'
    """
    fitted = {
        choice.names[0]: find_gain(explanation, choice.model) for choice in explanation.fits if len(choice.names) == 1
    }
    rows = [TriedCandidate(score.name, score.n_sigma, fitted.get(score.name)) for score in explanation.scores]
    return [row for place, row in enumerate(rows) if place < MAX_CANDIDATES or row.realised is not None]


def describe_added(explanation: "Explanation") -> str:
    """The part that was added to the machine, in words.

    Parameters
    ----------
    explanation : apesim.studies.gap.explanation.Explanation

    Returns
    -------
    str

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> describe_added(explain_example())
    'with side force'
    """
    model = explanation.best
    if model.released:
        return f"with {format_key(model.released)} corrected"
    return f"with {' and '.join(map(format_name, model.names))}"


def format_number(value: float | None, unit: str = "") -> str:
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
    >>> format_number(0.12345, "mm^2"), format_number(None)
    ('0.123 mm²', '-')
    """
    return "-" if value is None else f"{value:.3g} {format_unit(unit)}".rstrip()


def format_chance(p_value: float) -> str:
    """A chance as text, with two digits; below 1 in 10 000 only that is said.

    Parameters
    ----------
    p_value : float

    Returns
    -------
    str

    Examples
    --------
    >>> format_chance(0.0312), format_chance(3e-6)
    ('0.031', 'below 0.0001')
    """
    return "below 0.0001" if p_value < 1e-4 else f"{p_value:.2g}"


def _read_template() -> str:
    """The page as a template of Jinja, from ``template.html`` beside this file."""
    return files(__package__).joinpath("template.html").read_text(encoding="utf-8")


def render_page(
    explanation: "Explanation",
    data: Mapping[str, Any],
    compared: Sequence[ComparedSignal],
    figures: Mapping[str, str],
) -> str:
    """Render the page of an explanation as HTML.

    Parameters
    ----------
    explanation : apesim.studies.gap.explanation.Explanation
    data : dict
        Content of ``verdict.json``, with ``next_test`` and ``lineage``.
    compared : sequence of apesim.studies.gap.report.comparison.ComparedSignal
    figures : dict of str
        SVG by name.

    Returns
    -------
    str
        HTML; the same text each time, as no time or date is in it.

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> from apesim.studies.gap.report.comparison import compare_signals
    >>> explanation = explain_example()
    >>> compared = compare_signals(explanation)
    >>> text = render_page(explanation, explanation.to_dict(), compared, {"gap": "<svg/>", "maps": "<svg/>"})
    >>> explanation.sentence in text
    True
    """
    ambient = explanation.calibrated.residuals.machine.ambient.pressure
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {
        "number": format_number,
        "chance": format_chance,
        "words": format_name,
        "unit": format_unit,
        "key": format_key,
    }
    environment.filters |= {"value": format_value, "interval": format_interval, "limit": format_limit}
    environment.filters |= {"before": format_before, "after": format_after, "rounded": _format_rounded}
    effects = list_effects(explanation.calibrated.residuals.machine)
    ranges = {name: entry.parameters[0].range for name, entry in effects.items()}
    limits = [{"effect": name} | limit for name, limit in data["detection_limits"].items()]
    return environment.from_string(_read_template()).render(
        data=data,
        figures={name: base64.b64encode(text.encode()).decode() for name, text in figures.items()},
        unseen=any(signal.role == CHECK for signal in compared),
        check=find_check_sizes(compared),
        added=describe_added(explanation) if compared[0].residuals_after is not None else "",
        visible=sorted((row for row in limits if row["limit"] is not None), key=lambda row: row["effect"]),
        hidden=sorted((row | {"range": ranges[row["effect"]]} for row in limits if row["limit"] is None), key=_name),
        means=[
            (label_point(signal.block.run, ambient), find_display(signal.block), signal)
            for signal in compared
            if signal.is_mean
        ],
        runs=len(explanation.measured.runs),
        sensors=list(dict.fromkeys(signal.block.sensor for signal in compared)),
        explanations=list_explanations(explanation),
        judged=bool(explanation.measured.of(GATE)),
        units={signal.block.sensor: find_display(signal.block) for signal in compared},
        pull=MARKED_PULL,
        calibrated=is_explained(data),
        version=version("apesim"),
    )


def _format_rounded(value: float | None, decimals: int) -> str:
    """A number with so many digits after the point; "-" where there is none."""
    return "-" if value is None else f"{value:.{decimals}f}"


def format_name(name: str) -> str:
    """A name without underscores.

    Parameters
    ----------
    name : str

    Returns
    -------
    str

    Examples
    --------
    >>> format_name("side_force")
    'side force'
    """
    return name.replace("_", " ")


def format_unit(text: str) -> str:
    """A unit, or a text with units, with powers as they are printed.

    Parameters
    ----------
    text : str

    Returns
    -------
    str

    Examples
    --------
    >>> format_unit("N s^2/m^2")
    'N s²/m²'
    """
    return text.replace("^2", "²").replace("^3", "³")


def _name(row: dict[str, Any]) -> str:
    """Name of the effect of a row."""
    return row["effect"]


def format_key(key: str) -> str:
    """A key of the machine in words.

    Parameters
    ----------
    key : str

    Returns
    -------
    str

    Examples
    --------
    >>> format_key("effects.side_force.force")
    'side force, force'
    """
    return format_name(key.removeprefix("effects.").replace(".", ", "))


def find_check_sizes(compared: Iterable[ComparedSignal]) -> tuple[float, float | None] | None:
    """Root mean squares over the noise on the check runs, before and after something was added.

    Parameters
    ----------
    compared : iterable of apesim.studies.gap.report.comparison.ComparedSignal

    Returns
    -------
    before : float
    after : float or None
        None: nothing was added.

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> from apesim.studies.gap.report.comparison import compare_signals
    >>> before, after = find_check_sizes(compare_signals(explain_example()))
    >>> before > after
    True
    >>> find_check_sizes([]) is None  # no run is marked check
    True
    """
    checks = [signal for signal in compared if signal.role == CHECK]
    if not checks:
        return None
    after = [signal.residuals_after for signal in checks if signal.residuals_after is not None]
    return find_rms(signal.residuals_before for signal in checks), find_rms(after) if after else None


def list_explanations(explanation: "Explanation") -> list[dict[str, Any]]:
    """The models that were fitted, the best first.

    Parameters
    ----------
    explanation : apesim.studies.gap.explanation.Explanation

    Returns
    -------
    list of dict
        ``names``; ``cost``, penalised, above the least, by the fitted runs; ``judged``, the same with the runs that
        judge (None: it was not judged); ``realised``, the part of the gap that it explains [standard deviations].

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> best, *_ = list_explanations(explain_example())
    >>> best["names"], best["cost"]
    (['side_force'], 0.0)
    """
    min_cost = min((choice.cost for choice in explanation.fits), default=0.0)
    judged = {choice.names: choice.cost for choice in explanation.ranked} if explanation.measured.of(GATE) else {}
    rows = [
        {
            "names": list(choice.names),
            "cost": choice.cost - min_cost,
            "judged": judged[choice.names] - min(judged.values()) if choice.names in judged else None,
            "realised": find_gain(explanation, choice.model),
        }
        for choice in explanation.fits
    ]
    return sorted(rows, key=lambda row: (row["judged"] is None, row["judged"] or 0.0, row["cost"]))[:MAX_EXPLANATIONS]


def find_gain(explanation: "Explanation", model: Model) -> float:
    """The part of the gap that a fitted model takes away: the root of the fall of the sum of squares.

    Parameters
    ----------
    explanation : apesim.studies.gap.explanation.Explanation
    model : apesim.studies.estimation.model.Model

    Returns
    -------
    float
        [standard deviations]

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> round(find_gain(explain_example(), explain_example().best))
    13
    """
    return float(np.sqrt(max(0.0, explanation.calibrated.cost - model.cost)))
