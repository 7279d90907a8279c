"""Outcomes: what each result of an experiment would mean, by a number that a user can look at."""

from collections.abc import Sequence
from math import floor, isnan, log10, nan
from typing import Any

import numpy as np

from apesim.studies.gap.design.expected_information import find_information, find_separation
from apesim.studies.gap.design.forecasts import AS_IT_IS, NONE_OF_THEM, Alternative, Preview
from apesim.studies.gap.report.comparison import find_display
from apesim.studies.gap.search.phases import PHASES, Phase, find_phases
from apesim.studies.measured import VALVE

FLIGHTS = {Phase.OPENING_FLIGHT: ("opening", "energising"), Phase.CLOSING_FLIGHT: ("closing", "release")}
"""Flights of a valve: the stroke, and the command that begins it."""
MIN_CLEAR = 1.0
"""Sigmas from which a change of a number is worth a word: below, noise makes as much."""
MIN_SAMPLES = 3
"""Samples of a signal in a phase, below which it is not looked at."""


def describe_outcomes(preview: Preview, alternatives: Sequence[Alternative]) -> list[dict[str, Any]]:
    """Describe what each explanation foresees, in the signal and phase that would tell most between them.

    The number is a time at which half of the stroke is passed, where that phase is a flight of a valve whose lift is
    measured, and else the mean of the signal over the phase.

    Parameters
    ----------
    preview : apesim.studies.gap.design.forecasts.Preview
    alternatives : sequence of apesim.studies.gap.design.forecasts.Alternative

    Returns
    -------
    list of dict
        For each explanation ``explanation``, ``signal``, ``phase``, ``quantity`` in words, ``value`` and ``change`` from
        the machine as it is in ``unit``, and ``deviations``, by how many sigmas the machine as it is would miss this
        part of the record, everything fitted anew. ``value``, ``change`` and ``deviations`` of an effect that is not in
        the library are None.

    Examples
    --------
    >>> from apesim.studies.gap.design.experiments import list_experiments
    >>> from apesim.studies.gap.design.forecasts import preview_experiment
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> pair = [Alternative(c.names[0], 0.5, c.model) for c in explanation.fits if len(c.names) == 1][:2]
    >>> preview = preview_experiment(list_experiments(explanation.measured, 101325.0)[1], explanation, pair)
    >>> outcome, _ = describe_outcomes(preview, pair)
    >>> outcome["explanation"], outcome["signal"], outcome["deviations"] > MIN_CLEAR
    ('side_force', 'lift', True)
    """
    number, phase, rows = _choose_cell(preview, alternatives)
    block = preview.residuals.blocks[number]
    display = find_display(block)
    inside = _find_cells(preview)[number] == phase
    quantity, unit = f"mean {display.name}", display.unit
    if phase >= 0:
        quantity += f" in {PHASES[phase]}"

    def measure(values: list[np.ndarray]) -> float:
        return float(display.convert(np.mean(values[number][inside])))

    if phase >= 0 and PHASES[phase] in FLIGHTS and (preview.experiment.run.bench, block.sensor) == (VALVE, "lift"):
        stroke, command = FLIGHTS[PHASES[phase]]
        half = 0.5 * preview.residuals.machine.valve.stroke
        release = preview.experiment.run.pulse

        def pass_half(values: list[np.ndarray]) -> float:
            return 1e3 * _find_crossing(block.times, values[number] - half, release, is_opening=stroke == "opening")

        if not any(isnan(pass_half(values)) for values in (preview.base_values, *preview.values)):
            quantity, unit, measure = f"{stroke}: half of the stroke is passed after {command}", "ms", pass_half
    outcomes = []
    for alternative, forecast, values in zip(alternatives, preview.forecasts, preview.values, strict=True):
        is_known = alternative.model is not None
        value = measure(values)
        outcomes.append(
            {
                "explanation": alternative.name,
                "signal": block.sensor,
                "phase": str(PHASES[phase]) if phase >= 0 else None,
                "quantity": quantity,
                "value": value if is_known else None,
                "change": value - measure(preview.base_values) if is_known else None,
                "unit": unit,
                "deviations": find_separation(forecast.take(rows), preview.base.take(rows)) if is_known else None,
            }
        )
    return outcomes


def _find_cells(preview: Preview) -> list[np.ndarray]:
    """The phase of each sample, by block."""
    return [find_phases(block, preview.marks) for block in preview.residuals.blocks]


def _choose_cell(preview: Preview, alternatives: Sequence[Alternative]) -> tuple[int, int, np.ndarray]:
    """Number of the block, place of the phase, and rows of the samples, of the part that would tell most."""
    weights = [alternative.weight for alternative in alternatives]
    cells = _find_cells(preview)
    best: tuple[float, int, int, np.ndarray] | None = None
    for number, cell in enumerate(cells):
        for phase in np.unique(cell):
            rows = np.concatenate([(other == phase) & (k == number) for k, other in enumerate(cells)])
            if phase >= 0 and rows.sum() < MIN_SAMPLES:
                continue
            information = find_information([forecast.take(rows) for forecast in preview.forecasts], weights)
            if best is None or information > best[0]:
                best = information, number, int(phase), rows
    assert best is not None  # a run has a phase that is longer than some samples
    return best[1:]


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
    """Write what each outcome of an experiment would mean.

    Parameters
    ----------
    outcomes : sequence of dict
        See `describe_outcomes`.

    Returns
    -------
    str
        One sentence for each explanation.

    Examples
    --------
    >>> outcome = {"explanation": "side_force", "quantity": "mean lift in dwell", "value": 8.7134, "change": -0.2866}
    >>> print(write_outcomes([outcome | {"unit": "mm", "deviations": 12.3}]))
    Look at the mean lift in dwell. If it is side force: 8.71 mm, 0.29 mm less than the machine as it is says (12 sigmas).
    """
    sentences = [f"Look at the {outcomes[0]['quantity']}."]
    known = [outcome for outcome in outcomes if outcome["value"] is not None]
    decimals = min((_find_decimals(outcome) for outcome in known), default=0)
    for outcome in known:
        name, value, unit = outcome["explanation"].replace("_", " "), outcome["value"], outcome["unit"]
        start = "If nothing is missing" if name == AS_IT_IS else f"If it is {name}"
        text = f"{start}: {value:.{max(decimals, 0)}f} {unit}"
        if name != AS_IT_IS and outcome["deviations"] >= MIN_CLEAR:
            way = "more" if outcome["change"] > 0.0 else "less"
            way = way if unit != "ms" else {"more": "later", "less": "earlier"}[way]
            change = f"{abs(outcome['change']):.{max(decimals, 0)}f} {unit}"
            text += f", {change} {way} than {AS_IT_IS} says ({outcome['deviations']:.2g} sigmas)"
        elif name != AS_IT_IS:
            text += f", hardly other than {AS_IT_IS} says ({outcome['deviations']:.1f} sigmas)"
        sentences.append(f"{text}.")
    if len(known) < len(outcomes):
        sentences.append(f"If the record fits none of these, it is {NONE_OF_THEM}.")
    return " ".join(sentences)


def _find_decimals(outcome: dict[str, Any]) -> int:
    """Decimals by which the change of a number is shown with no more digits than its error, one sigma."""
    error = abs(outcome["change"]) / max(outcome["deviations"], 1.0)
    return -floor(log10(error)) if error > 0.0 else 12
