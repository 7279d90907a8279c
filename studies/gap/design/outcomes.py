"""Outcomes: what each result of an experiment would mean, by a number that a user can look at."""

from collections.abc import Iterator, Sequence
from math import floor, isnan, log10, nan
from typing import Any, NamedTuple

import numpy as np

from apesim.studies.gap.design.expected_information import find_entropy, find_information, find_separation
from apesim.studies.gap.design.forecasts import AS_IT_IS, NONE_OF_THEM, Alternative, Preview
from apesim.studies.gap.report.comparison import find_display
from apesim.studies.gap.report.rounding import format_sigmas
from apesim.studies.gap.search.phases import PHASES, Phase, find_phases
from apesim.studies.measured import VALVE

FLIGHTS = {"opening flight": ("opening", "energising"), "closing flight": ("closing", "release")}
"""Flights of a valve: the stroke, and the command that begins it."""
STEP_TOLD = 0.05
"""Share of what is open by which one part of a record has to tell more than another to be looked at instead: a time
of a flight is seen more easily than a mean."""
MIN_CLEAR = 1.0
"""Sigmas from which a change of a number is worth a word: below, noise makes as much."""
MIN_TELLS = 0.5
"""Share of what is open that a part of the record has to settle, for its number to be more than an example."""
MIN_SAMPLES = 3
"""Samples of a signal in a phase, below which it is not looked at."""
MAX_WRITTEN = 3
"""Explanations whose outcomes are written in words: more would not be read."""


def describe_outcomes(preview: Preview, alternatives: Sequence[Alternative]) -> list[dict[str, Any]]:
    """Describe what each explanation foresees, in the signal and phase that would tell most between them.

    The number, in words its ``quantity``, is a time at which half of the stroke is passed, where the phase is a flight
    of a valve whose lift is measured, else the mean of the signal over the phase. ``change`` from the machine as it is,
    ``value`` and ``deviations``, by how many sigmas that machine would miss this part with everything fitted anew, are
    None of an effect that is not in the library; ``tells`` is the share of what is open between the others that this
    part alone is expected to settle, ``decimals`` the digits that the numbers are worth.
    """
    part, tells = _choose_part(preview, alternatives)
    block, inside = preview.residuals.blocks[part.number], part.inside

    # The mean over the phase, which any signal has.
    display = find_display(block)
    quantity, unit = f"mean {display.name}{f' in {part.name}' if part.name else ''}", display.unit

    def measure(values: list[np.ndarray]) -> float:
        return float(display.convert(np.mean(values[part.number][inside])))

    # A time is more easily seen, but there is one only where every explanation passes half of the stroke.
    if _is_flight(part, preview):
        stroke, command = FLIGHTS[part.name]
        half, release = 0.5 * preview.residuals.machine.valve.stroke, preview.experiment.run.pulse

        def pass_half(values: list[np.ndarray]) -> float:
            height = values[part.number] - half
            return 1e3 * _find_crossing(block.times, height, release, is_opening=stroke == "opening")

        if not any(isnan(pass_half(values)) for values in (preview.base_values, *preview.values)):
            quantity, unit, measure = f"time from {command} to half of the stroke", "ms", pass_half

    # What is not in the library has no values of its own, so that it is given no number.
    outcomes = []
    for alternative, forecast, values in zip(alternatives, preview.forecasts, preview.values, strict=True):
        is_known = alternative.model is not None
        value = measure(values)
        outcomes.append(
            {
                "explanation": alternative.name,
                "signal": block.sensor,
                "phase": part.name or None,
                "quantity": quantity,
                "value": value if is_known else None,
                "change": value - measure(preview.base_values) if is_known else None,
                "unit": unit,
                "tells": tells,
                "deviations": find_separation(forecast.take(part.rows), preview.base.take(part.rows))
                if is_known
                else None,
            }
        )

    # The same decimals for all, as the numbers are there to be compared.
    decimals = find_decimals([outcome for outcome in outcomes if outcome["value"] is not None])
    return [outcome | {"decimals": decimals} for outcome in outcomes]


class _Part(NamedTuple):
    """A part of an experiment's record: a signal in a phase."""

    number: int
    """Number of the block."""
    name: str
    """Name of the phase; "": a mean over the cycle."""
    inside: np.ndarray
    """Whether each sample of the block is in it."""
    rows: np.ndarray
    """Whether each sample of the experiment is in it, block after block."""


def _list_parts(preview: Preview) -> Iterator[_Part]:
    """The parts of a record that can be looked at; on a valve, those after both commands apart, and none at rest."""
    blocks = preview.residuals.blocks
    for number, block in enumerate(blocks):
        cell = find_phases(block, preview.marks)
        for phase in np.unique(cell):
            parts = {PHASES[phase].value if phase >= 0 else "": cell == phase}
            if block.run.bench == VALVE:
                parts = _split_strokes(PHASES[phase], block.times, cell == phase, block.run.pulse)
            for name, inside in parts.items():
                if phase < 0 or inside.sum() >= MIN_SAMPLES:
                    others = [
                        inside if k == number else np.zeros(len(each.values), bool) for k, each in enumerate(blocks)
                    ]
                    yield _Part(number, name, inside, np.concatenate(others))


def _split_strokes(phase: Phase, times: np.ndarray, inside: np.ndarray, release: float) -> dict[str, np.ndarray]:
    """A phase of a valve, after energising and after release."""
    opening, closing = inside & (times >= 0.0) & (times < release), inside & (times >= release)
    match phase:
        case Phase.DEAD_TIME:
            return {"dead time after energising": opening, "dead time after release": closing}
        case Phase.IMPACT:
            return {"impact on opening": opening, "impact on closing": closing}
        case Phase.DWELL:
            return {"dwell": opening}
        case _:
            return {str(phase): inside}


def _is_flight(part: _Part, preview: Preview) -> bool:
    """Whether a part is a flight of a valve whose lift is measured."""
    block = preview.residuals.blocks[part.number]
    return part.name in FLIGHTS and (block.run.bench, block.sensor) == (VALVE, "lift")


def _choose_part(preview: Preview, alternatives: Sequence[Alternative]) -> tuple[_Part, float]:
    """The part of a record that would tell most, and the share of what is open that it would settle.

    Of parts that tell as much, a flight is taken. An effect that is not in the library gives no number, and has no say.
    """
    known = [k for k, alternative in enumerate(alternatives) if alternative.model]
    forecasts = [preview.forecasts[k] for k in known] if len(known) > 1 else preview.forecasts
    weights = np.array([alternatives[k].weight for k in known] if len(known) > 1 else [a.weight for a in alternatives])
    weights /= weights.sum()
    step = STEP_TOLD * max(find_entropy(weights), 1e-6)

    def rank(part: _Part) -> tuple[int, bool, float]:
        information = find_information([forecast.take(part.rows) for forecast in forecasts], weights)
        return round(information / step), _is_flight(part, preview), information

    ranked = {rank(part): part for part in _list_parts(preview)}
    best = max(ranked)
    return ranked[best], STEP_TOLD * best[2] / step


def _find_crossing(times: np.ndarray, height: np.ndarray, release: float, *, is_opening: bool) -> float:
    """Time after its command at which a height (n,) first passes zero, upwards or downwards; NaN: it never does."""
    start = 0.0 if is_opening else release
    upwards = height if is_opening else -height
    passed = (upwards[1:] >= 0.0) & (upwards[:-1] < 0.0) & (times[1:] > start)
    if not passed.any():
        return nan
    k = int(np.argmax(passed))
    share = -upwards[k] / (upwards[k + 1] - upwards[k])
    return float(times[k] + share * (times[k + 1] - times[k]) - start)


def write_outcomes(outcomes: Sequence[dict[str, Any]]) -> str:
    """Write what the outcomes of an experiment would mean; `describe_outcomes` gives them, the best explanation first.

    There is a sentence for each of the best `MAX_WRITTEN` explanations, and for the machine as it is and for what is
    not in the library where these are in play.

    >>> outcome = {"explanation": "side_force", "quantity": "mean lift in dwell", "value": 8.7134, "change": -0.2866}
    >>> print(write_outcomes([outcome | {"unit": "mm", "deviations": 0.6, "tells": 0.9, "decimals": 1}]))
    Look at the mean lift in dwell. If it is side force: 8.7 mm, as the machine as it is says, within 1 sigma.
    """
    look = f"Look at the {outcomes[0]['quantity']}."
    if outcomes[0]["tells"] < MIN_TELLS:
        look = f"No single number tells, the whole record does. Most tells the {outcomes[0]['quantity']}."
    sentences = [look]
    known = [outcome for outcome in outcomes if outcome["value"] is not None]
    named = [outcome for outcome in known if outcome["explanation"] != AS_IT_IS][:MAX_WRITTEN]
    decimals = outcomes[0]["decimals"]
    for outcome in named:
        value = f"{outcome['value']:.{decimals}f} {outcome['unit']}"
        sentences.append(
            f"If it is {outcome['explanation'].replace('_', ' ')}: {value}, {format_change(outcome, decimals)}."
        )
    for outcome in known:
        if outcome["explanation"] == AS_IT_IS:
            sentences.append(f"If nothing is missing: {outcome['value']:.{decimals}f} {outcome['unit']}.")
    if len(known) < len(outcomes):
        sentences.append(f"If the record fits none of these, it is {NONE_OF_THEM}.")
    return " ".join(sentences)


def format_change(outcome: dict[str, Any], decimals: int) -> str:
    """How far an outcome with a value, see `describe_outcomes`, is from the machine as it is, in words.

    >>> format_change({"change": 0.8213, "unit": "ms", "deviations": 11.6}, 2)
    '0.82 ms later than the machine as it is says (12 sigmas)'
    >>> format_change({"change": 0.01, "unit": "ms", "deviations": 0.3}, 2)
    'as the machine as it is says, within 1 sigma'
    """
    if outcome["deviations"] < MIN_CLEAR:
        return f"as {AS_IT_IS} says, within {MIN_CLEAR:g} sigma"
    words = ("earlier", "later") if outcome["unit"] == "ms" else ("less", "more")
    change = f"{abs(outcome['change']):.{decimals}f} {outcome['unit']}"
    n_sigma = format_sigmas(outcome["deviations"])
    return f"{change} {words[outcome['change'] > 0.0]} than {AS_IT_IS} says ({n_sigma} sigmas)"


def find_decimals(outcomes: Sequence[dict[str, Any]]) -> int:
    """Decimals with which the numbers of outcomes are shown: none beyond the error of one sigma.

    The outcomes are those of `describe_outcomes` that have a value.
    """
    errors = [
        abs(outcome["change"]) / outcome["deviations"] for outcome in outcomes if outcome["deviations"] >= MIN_CLEAR
    ]
    if not errors or max(errors) <= 0.0:
        return 1
    return max(0, -floor(log10(max(errors))))
