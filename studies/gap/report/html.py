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
from apesim.studies.gap.report.chances import list_chances
from apesim.studies.gap.report.comparison import ComparedSignal, find_display, find_rms
from apesim.studies.gap.report.curve_notes import write_misses, write_reach, write_trace
from apesim.studies.gap.report.effect_rows import format_interval, format_value
from apesim.studies.gap.report.engine_curve import EngineCurve
from apesim.studies.gap.report.extended_machine import is_explained
from apesim.studies.gap.report.likely_cause import describe_change, write_hint
from apesim.studies.gap.report.rounding import format_chance, format_sigmas, format_size, round_to_error
from apesim.studies.gap.report.run_scatter import write_scatter
from apesim.studies.gap.report.words import format_explanation, format_key, format_name
from apesim.studies.gap.search.detection_limits import format_limit
from apesim.studies.gap.search.gap_test import DRAWS
from apesim.studies.gap.search.library import list_effects
from apesim.studies.gap.thresholds import AMBIGUOUS_COST
from apesim.studies.measured import CHECK, FIT, GATE, Role

if TYPE_CHECKING:
    from apesim.studies.gap.explanation import Explanation

MAX_CANDIDATES = 12
"""Candidates that are shown at most: those that are fitted alone for their score."""
MAX_EXPLANATIONS = 8
"""Models that are shown at most: more would not be read."""
MARKED_PULL = 2.0
"""Prior standard deviations beyond which a pull is marked: noise alone pulls one of twenty nuisances so far."""
MAX_WARNINGS = 3
"""Warnings that are shown at once; the others are folded, as more would not be read."""
ROLES_SHOWN = {FIT: "on the fitted runs", CHECK: "on runs that were never used"}
"""Runs whose gap stands at the head of the page, by their role."""
TERMS = {
    "gap": "what the model leaves of the data, more than noise does; as a number it is their root mean square over the "
    "noise, and noise alone gives 1",
    "noise": "the scatter of single samples about what the sensor would read on average",
    "sigma": "one standard deviation of the noise; noise alone gives 2 once in twenty times, 5 once in a million",
    "score": "how large the gap is along what the effect does to the data, in sigmas, before anything is fitted",
    "penalised cost": "the sum of squares that is left, in sigmas squared, and a price for each effect; less is better",
    "retained": "the share of an effect that is left once the uncertain numbers of the machine have been fitted",
    "cosine": "how much two effects do the same to these data; 1: the very same, 0: nothing in common",
    "known to": "the standard deviation of a number before the data were looked at, also called its prior",
    "pull": "how far the data moved a number, in standard deviations of what was known of it",
    "white": "each sample has an error of its own; a colour of some order: neighbouring samples err alike",
    "hum": "what the mains add to a signal, at their frequency",
}
"""Terms of the page, explained where they stand."""


class TriedCandidate(NamedTuple):
    """A candidate with the part of the gap that its score promises, and the part that its fit takes away."""

    name: str
    """Name of the effect."""
    expected: float
    """Part of the gap that its score promises [standard deviations]."""
    realised: float | None
    """Part of the gap that its fit alone takes away [standard deviations]; None: it was not fitted."""


def compare_candidates(explanation: "Explanation") -> list[TriedCandidate]:
    """The candidates with the highest scores, and the others that were fitted alone; the highest score first."""
    fitted = {
        choice.names[0]: find_gain(explanation, choice.model) for choice in explanation.fits if len(choice.names) == 1
    }
    rows = [TriedCandidate(score.name, score.n_sigma, fitted.get(score.name)) for score in explanation.scores]
    return [row for place, row in enumerate(rows) if place < MAX_CANDIDATES or row.realised is not None]


def describe_added(explanation: "Explanation") -> str:
    """The part that was added to the machine, in words."""
    model = explanation.best
    added = [format_key(each.name) for each in model.candidates]
    return f"with {' and '.join([*added, *(f'{format_key(key)} corrected' for key in model.corrected)])}"


def format_pull(row: Mapping[str, Any]) -> str:
    """The pull of a calibrated number as text, with the digits that the data leave it; see `describe_nuisances`."""
    text = round_to_error(row["deviations"], row["deviations_error"])
    return text if text.startswith("-") or text == "0" else f"+{text}"


def write_as_sentence(text: str) -> str:
    """A text with a capital and a full stop."""
    first, rest = text[:1], text[1:]
    is_name = "." in text.split(" ")[0]  # a file's name keeps its letters
    return f"{first if is_name else first.upper()}{rest.removesuffix('.')}."


def _read_template() -> str:
    """The page as a template of Jinja, from ``template.html`` beside this file."""
    return files(__package__).joinpath("template.html").read_text(encoding="utf-8")


def render_page(
    explanation: "Explanation",
    data: Mapping[str, Any],
    compared: Sequence[ComparedSignal],
    figures: Mapping[str, str],
    curves: Sequence[EngineCurve] = (),
) -> str:
    """Render the page of an explanation as HTML, the same text each time, as no time or date is in it.

    `data` is the content of ``verdict.json``, with ``next_test`` and ``lineage``; `figures` are SVG by name, and
    `curves` are means over the speed, where there is nothing else.
    """
    ambient = explanation.calibrated.residuals.machine.ambient.pressure

    # Names of files and what users wrote in them go into the page, so that all texts are escaped.
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {
        "rounded": round_to_error,
        "size": format_size,
        "sigmas": format_sigmas,
        "pull": format_pull,
        "sentence": write_as_sentence,
        "change": describe_change,
        "hint": write_hint,
        "chance": lambda p_value: format_chance(p_value, DRAWS),
        "words": format_name,
        "unit": format_unit,
        "key": format_explanation,
    }
    environment.filters |= {"value": format_value, "interval": format_interval, "limit": format_limit}
    environment.filters |= {"before": format_before, "after": format_after, "decimals": _format_decimals}

    # What the data do not show at any size is told with the range up to which it was looked for.
    limits = [{"effect": name} | limit for name, limit in data["detection_limits"].items()]
    ranges = find_ranges(explanation, [row["effect"] for row in limits if row["limit"] is None])

    added = describe_added(explanation) if compared[0].residuals_after is not None else ""
    fitted_means = sum(signal.is_mean and signal.role == FIT for signal in compared)

    # Beside the verdict: what only traces and fits tell, and the numbers above which the page marks or folds.
    return environment.from_string(_read_template()).render(
        data=data,
        figures={name: base64.b64encode(text.encode()).decode() for name, text in figures.items()},
        bench=explanation.measured.bench,
        sizes=[(said, role == FIT, own) for role, said in ROLES_SHOWN.items() if (own := find_sizes(compared, role))],
        check=find_sizes(compared, CHECK),
        added=added,
        visible=sorted((row for row in limits if row["limit"] is not None), key=lambda row: row["effect"]),
        hidden=sorted((row | {"range": ranges[row["effect"]]} for row in limits if row["limit"] is None), key=_name),
        means=[
            (label_point(signal.block.run, ambient), find_display(signal.block), signal)
            for signal in compared
            if signal.is_mean
        ],
        runs=len(explanation.measured.runs),
        sensors=_list_words(dict.fromkeys(signal.block.sensor for signal in compared)),
        reach=[write_misses(curves, added), write_reach(data, fitted_means), *write_trace(data)] if curves else [],
        notes=[*list_chances(data), *write_scatter(data)],
        explanations=list_explanations(explanation),
        judged=bool(explanation.measured.of(GATE)),
        units={signal.block.sensor: find_display(signal.block) for signal in compared},
        pull=MARKED_PULL,
        terms=TERMS,
        max_warnings=MAX_WARNINGS,
        folded=bool(data["likely_cause"]),
        calibrated=is_explained(data),
        version=version("apesim"),
    )


def _format_decimals(value: float | None, decimals: int) -> str:
    """A number with so many digits after the point; "-" where there is none."""
    return "-" if value is None else f"{value:.{decimals}f}"


def format_unit(text: str) -> str:
    """A unit, or a text with units, with powers as they are printed.

    >>> format_unit("N s^2/m^2")
    'N s²/m²'
    """
    return text.replace("^2", "²").replace("^3", "³")


def _list_words(names: Iterable[str]) -> str:
    """Names in words, the last one behind "and"."""
    *first, last = map(format_name, names)
    return f"{', '.join(first)} and {last}" if first else last


def _name(row: dict[str, Any]) -> str:
    """Name of the effect of a row."""
    return row["effect"]


def find_ranges(explanation: "Explanation", names: Iterable[str]) -> dict[str, str]:
    """Ranges within which effects, and numbers of the machine file, were looked for, as text by their names."""
    effects, ranges = list_effects(explanation.calibrated.residuals.machine), {}
    for name in names:
        if name in effects:
            ranges[name] = effects[name].parameters[0].range
            continue
        number = next(row.probe.parameter for row in explanation.sensitivities if row.probe.candidate.name == name)
        unit = number.declaration.unit  # type: ignore[attr-defined]
        low, high = (number.shown(number.value(end)) for end in number.ends)
        ranges[name] = f"{low:.3g} to {high:.3g} {unit}".strip()
    return ranges


def find_sizes(compared: Iterable[ComparedSignal], role: Role) -> tuple[float, float | None, int] | None:
    """Root mean squares over the noise on runs of a role, before and after something was added, and their samples.

    After is None where nothing was added; None in all where no run has the role.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> from apesim.studies.gap.report.comparison import compare_signals
    >>> before, after, _ = find_sizes(compare_signals(explain_example()), CHECK)
    >>> before > after
    True
    >>> find_sizes([], CHECK) is None  # no run is marked check
    True
    """
    own = [signal for signal in compared if signal.role == role]
    if not own:
        return None
    after = [signal.residuals_after for signal in own if signal.residuals_after is not None]
    samples = sum(len(signal.residuals_before) for signal in own)
    return find_rms(signal.residuals_before for signal in own), find_rms(after) if after else None, samples


def list_explanations(explanation: "Explanation") -> list[dict[str, Any]]:
    """The models that were fitted, the best first.

    ``cost`` is the penalised one above the least, by the fitted runs; ``judged`` counts the runs that judge, too (None:
    it was not judged), and ``is_near`` says by it, if there is one, that the data do not distinguish the model from the
    best. ``realised`` is the part of the gap that it explains [standard deviations].
    """
    min_cost = min((choice.cost for choice in explanation.fits), default=0.0)
    judged = {choice.names: choice.cost for choice in explanation.ranked} if explanation.measured.of(GATE) else {}
    rows: list[dict[str, Any]] = []
    for choice in explanation.fits:
        cost = choice.cost - min_cost
        other = judged[choice.names] - min(judged.values()) if choice.names in judged else None
        rows.append(
            {
                "names": list(choice.names),
                "cost": cost,
                "judged": other,
                "is_near": (cost if other is None else other) < AMBIGUOUS_COST,
                "realised": find_gain(explanation, choice.model),
            }
        )
    return sorted(rows, key=lambda row: (row["judged"] is None, row["judged"] or 0.0, row["cost"]))[:MAX_EXPLANATIONS]


def find_gain(explanation: "Explanation", model: Model) -> float:
    """The part of the gap that a fitted model takes away [standard deviations]: the root of the fall of its cost.

    The fall is from the sum of squares of the calibrated machine; 0 where the model does not lower it.
    """
    return float(np.sqrt(max(0.0, explanation.calibrated.cost - model.cost)))
