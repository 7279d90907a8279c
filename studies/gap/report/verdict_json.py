"""An explanation as plain data: what ``verdict.json`` holds."""

from collections.abc import Sequence
from math import sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from apesim.engine.stated_uncertainties import format_known_to
from apesim.quantities.uncertainties import Uncertainty
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.parameters import SENSED
from apesim.studies.estimation.priors import priors_of
from apesim.studies.gap.decide.consistency import Inconsistency
from apesim.studies.gap.decide.facts import find_refusal
from apesim.studies.gap.decide.held_out import HeldOut
from apesim.studies.gap.decide.operating_points import label_point
from apesim.studies.gap.decide.reliability import describe_inclusion, find_probability, list_statements
from apesim.studies.gap.decide.verdict import Decision
from apesim.studies.gap.reasons import NAMING, ReasonKind, Verdict
from apesim.studies.gap.report.calibrated_numbers import describe_value
from apesim.studies.gap.report.discrepancy import describe_discrepancy, describe_left, format_sizes
from apesim.studies.gap.report.effect_rows import describe_effects, describe_numbers, format_value
from apesim.studies.gap.report.likely_cause import describe_cause
from apesim.studies.gap.report.rounding import find_error, round_to_error
from apesim.studies.gap.report.run_scatter import describe_scatter
from apesim.studies.gap.report.words import format_key
from apesim.studies.gap.search.candidates import SAME_IN_RECORD
from apesim.studies.gap.search.detection_limits import find_detection_limits
from apesim.studies.gap.search.model_selection import PricedModel
from apesim.studies.gap.search.run_faults import FaultKind, find_files
from apesim.studies.gap.tables.balance import Balance, BalanceKind
from apesim.studies.gap.tables.tabulate import Tabulated

if TYPE_CHECKING:
    from apesim.studies.gap.explanation import Explanation

LEAVING = frozenset(
    {ReasonKind.GAP_LEFT, ReasonKind.GAP_STILL_THERE, ReasonKind.MORE_THAN_NOISE_LEFT, ReasonKind.TABLE_TAKES_MORE}
)
"""Reasons of a refusal by what is left, which a model that may be off would not be refused for."""
ARTICLES = {
    BalanceKind.FORCE: "a force",
    BalanceKind.HEAT: "heat",
    BalanceKind.LEAK: "leaks",
    BalanceKind.AREA: "a flow area",
    BalanceKind.DELAY: "a delay",
}
"""Balances with their articles, for a sentence."""
READINGS = "effects.sensor_offset.", "effects.sensor_gain."
"""Beginnings of the keys for what an instrument reads too much."""
CORRECTED = "key", "value", "unit", "interval_95"
"""What ``calibration`` has of each number that is wrong."""
MAX_LISTED = 4
"""Explanations that a sentence lists: ``alternatives`` has all."""
NOTHING_ELSE = ("nothing else",)
"""What an explanation has beside what is sure, where that is all of it."""


def _best(decision: Decision) -> PricedModel:
    """The best explanation of a decision that has one."""
    assert decision.best is not None
    return decision.best


def describe(explanation: "Explanation") -> dict[str, Any]:
    """The content of ``verdict.json``, without ``lineage``, ``next_test`` and ``wall_time_s``."""
    decision, tabulated = explanation.decision, explanation.tabulated

    # What is claimed, and how often such claims were right. The verdict of a tie claims nothing, and without an alarm
    # there is no gap to localise.
    statements, is_tie = list_statements(explanation), decision.verdict == Verdict.AMBIGUOUS
    said = [each._asdict() | {"probability": find_probability(each)} for each in statements]
    cells = explanation.cells if explanation.gap_test.alarm else []

    # The best explanation is told as what is missing where it is named, else as what comes nearest.
    named = decision.verdict in NAMING
    effects = describe_effects(decision.best.model) if decision.best else []
    numbers = describe_numbers(decision.best.model) if decision.best else []
    if decision.verdict == Verdict.MEASUREMENT:  # of the rig the other files speak
        effects, numbers = [row for row in effects if row["file"]], []
    corrected = effects if decision.verdict == Verdict.CALIBRATION else numbers
    discrepancy = describe_discrepancy(explanation.calibrated)
    left = describe_left(decision.best.model) if decision.best else {}

    # There are rivals only beside a best explanation, and their costs count above its.
    rivals = [
        {
            "effects": list(choice.names),
            "cost": choice.cost - _best(decision).cost,
            "parameters": [*describe_effects(choice.model), *describe_numbers(choice.model)],
        }
        for choice in decision.rivals
    ]
    return {
        "verdict": str(decision.verdict),
        "sentence": write_sentence(explanation) + write_discrepancy(decision, discrepancy, left),
        "reason": str(decision.reason),
        "effects": effects if named else [],
        "sure": describe_sure(decision),
        "numbers": numbers,
        "files": find_files(decision.best.model.candidates) if decision.best and named else [],
        "rest": describe_rest(explanation.rest) if explanation.rest else None,
        "odd_channels": [channel._asdict() for channel in explanation.odd],
        "nearest": [] if named else effects,
        "likely_cause": describe_cause(explanation, describe_added(effects)),
        "class": list_class(decision) if named else [],
        "alternatives": rivals,
        "probability": said[0]["probability"] if said and not is_tie else None,
        "inclusion": describe_inclusion(statements),
        "statements": said,
        "models": describe_models(explanation.calibrated, explanation.ranked),
        "alarm": explanation.gap_test.alarm,
        "p_value": explanation.gap_test.p_value,
        "largest_score": explanation.gap_test.largest,
        "largest_pair": {"effects": list(explanation.gap_test.pair), "deviations": explanation.gap_test.largest_pair},
        "gap": describe_gap(explanation.calibrated, explanation.best),
        "held_out": describe_held_out(explanation.checked),
        "gates": describe_held_out(explanation.judged),
        "localised": {
            "signal": cells[0].signal if cells else None,
            "phase": cells[0].phase if cells else None,
            "size": explanation.gap_size,
            "balance": explanation.balances[0].balance if explanation.balances else None,
            "balances": [describe_balance(balance) for balance in explanation.balances],
            "shares": [cell._asdict() for cell in cells if cell.share > 0.01],
        },
        "tabulated": _describe_table(tabulated, explanation.calibrated, explanation.tolerance) if tabulated else None,
        "detection_limits": find_detection_limits(explanation.sensitivities),
        "scores": [{"effect": score.name, "deviations": score.n_sigma} for score in explanation.scores],
        "nuisances": describe_nuisances(explanation),
        "noise": describe_noise(explanation.noise),
        "scatter": describe_scatter(explanation.calibrated.residuals),
        "own_error": explanation.solver_error,
        "tolerance": explanation.tolerance,
        "discrepancy": discrepancy,
        "left": left,
        "calibration": [{name: row[name] for name in CORRECTED} for row in corrected],
        "simulations": explanation.simulations,
        "warnings": explanation.warnings,
    }


def describe_sure(decision: Decision) -> list[dict[str, Any]]:
    """What is missing, or a number that is wrong, whatever explains the rest of an ambiguous gap; [] where nothing is.

    Rows as `describe_effects` has them, with the values of the best explanation; ``class`` is what the data do not
    distinguish from it.
    """
    if not decision.sure:
        return []
    twins, model = {name: list(others) for name, *others in decision.sure}, _best(decision).model
    rows = (*describe_effects(model), *describe_numbers(model))
    return [row | {"class": twins[row["name"]]} for row in rows if row["name"] in twins]


def list_class(decision: Decision) -> list[str]:
    """What is named, and all that these data do not distinguish from it, each once; errors of the record last.

    `decision` has a best explanation; effects are given by their names, numbers of the machine by their keys.
    """
    choices = (_best(decision), *decision.rivals)
    names = dict.fromkeys(name for choice in choices for name in choice.names)
    return [*names, *_list_same_in_record(decision)]


def _list_same_in_record(decision: Decision) -> list[str]:
    """Errors of the record that do the same as a number of the machine that is named, or is a rival."""
    names = [name for choice in (_best(decision), *decision.rivals) for name in choice.names]
    return [SAME_IN_RECORD[name] for name in names if name in SAME_IN_RECORD]


def describe_models(base: Model, choices: Sequence[PricedModel]) -> list[dict[str, Any]]:
    """The models that were fitted, with their penalised costs; the calibrated machine, without effects, among them.

    `choices` have the least cost first, ``cost`` counts above it; [] where nothing was fitted.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> models = describe_models(explain_example().calibrated, explain_example().ranked)
    >>> models[0], models[-1]["effects"]
    ({'effects': ['side_force'], 'cost': 0.0}, [])
    """
    if not choices:
        return []
    least = min(base.cost, choices[0].cost)
    priced = [(base.cost, ()), *((choice.cost, choice.names) for choice in choices)]
    rows = [{"effects": list(names), "cost": cost - least} for cost, names in priced]
    return sorted(rows, key=lambda row: row["cost"])


def describe_rest(rest: "Explanation") -> dict[str, Any]:
    """The verdict on the files that are left, where the record of one is wrong."""
    described = describe(rest)
    shared = ["verdict", "sentence", "reason", "effects", "numbers", "nearest", "class", "alternatives", "gap", "files"]
    shared += ["sure", "rest", "probability", "inclusion", "statements", "models"]
    return {name: described[name] for name in shared}


def describe_nuisances(explanation: "Explanation") -> list[dict[str, Any]]:
    """The uncertain numbers of the machine where the calibration left them, the farthest from their prior first.

    ``before`` and ``value`` are None where every run states the number itself: then ``shift`` in ``shift_unit`` says
    how much more it is than that. ``known_to`` is the standard deviation beforehand, as text, and ``stated_in`` says
    who states it; ``deviations`` is the pull and ``deviations_error`` its standard deviation by the data; ``apart`` is
    the operating point that alone leads farthest from the value, None where that is not known.
    """
    model = explanation.best
    machine, runs = model.residuals.machine, model.residuals.runs
    apart = {each.parameter.key: _describe_inconsistency(each, model) for each in explanation.consistency}
    stated_in = {prior.key: prior.stated_in for prior in priors_of(machine, explanation.measured)}
    left = [min(1.0, float(np.sqrt(variance))) for variance in np.diag(model.fitted.covariance)]
    rows = [
        {
            "key": p.key,
            **describe_value(machine, p, x, runs, left[j]),
            "known_to": format_known_to(p.key, Uncertainty(p.scale, p.relative)),
            "stated_in": stated_in[p.key],
            "deviations": float(x),
            "deviations_error": left[j],
            "apart": apart.get(p.key),
        }
        for j, (p, x) in enumerate(zip(model.residuals.parameters, model.fitted.x, strict=True))
        if p.prior
    ]
    return sorted(rows, key=lambda row: -abs(row["deviations"]))


def _describe_inconsistency(inconsistency: Inconsistency, model: Model) -> dict[str, Any]:
    """The value of a parameter that an operating point alone gives."""
    machine, runs = model.residuals.machine, model.residuals.runs
    described = describe_value(machine, inconsistency.parameter, inconsistency.x, runs)
    return {
        "run": label_point(inconsistency.run, machine.ambient.pressure),
        "value": described["value"],
        "shift": described["shift"],
        "deviations": float(inconsistency.n_sigma),
    }


def describe_gap(base: Model, best: Model) -> dict[str, float]:
    """The gap on the fitted runs, root mean squares over the noise.

    ``before`` is that of the calibrated machine `base`, ``after`` that of `best`, with what was added, and
    ``noise_floor`` what noise alone leaves of a fit with so many parameters.
    """
    before, after = base.fitted.data_residuals, best.fitted.data_residuals
    n = len(before)
    return {
        "before": float(np.sqrt(before @ before / n)),
        "after": float(np.sqrt(after @ after / n)),
        "noise_floor": sqrt(max(0.0, 1.0 - len(base.fitted.x) / n)),
    }


def describe_balance(balance: Balance) -> dict[str, Any]:
    """The part of the gap that a table takes away, in a model that is linear in its nodes."""
    return {
        "balance": balance.balance,
        "table": balance.name,
        "deviations": sqrt(max(0.0, balance.fall)),
        "gain": balance.gain,
    }


def _describe_table(tabulated: Tabulated, base: Model, tolerance: float) -> dict[str, Any]:
    """The table that was added in place of a law."""
    refused = find_refusal(tabulated.judged, tolerance) if tabulated.judged else None
    return {
        "kind": tabulated.balance.name,
        "balance": tabulated.balance.balance,
        "parameters": describe_effects(tabulated.model),
        "gap": describe_gap(base, tabulated.model),
        "held_out": describe_held_out(tabulated.judged),
        "verified": not refused if tabulated.judged else None,
        "reason": str(refused or ""),
        "suggestion": tabulated.suggestion,
    }


def describe_noise(noise: dict[str, Any]) -> list[dict[str, Any]]:
    """The noise of each sensor, at each sampling interval, from what `noise_of` gives."""
    return [
        {
            "sensor": sensor,
            "deviation": n.deviation,
            "order": n.order,
            "hum_hz": [f for f, _ in n.hums],
            "source": n.source,
        }
        for sensor, by_interval in noise.items()
        for n in by_interval.values()
    ]


def describe_held_out(judged: HeldOut | None) -> dict[str, float] | None:
    """The gap on runs that nothing was fitted to; None where there are no such runs.

    >>> judged = HeldOut(100, 3.0, 1.2, removed_energy=800.0, remaining_energy=50.0, remaining_sigma=10.0)
    >>> round(describe_held_out(judged)["removed_share"], 3)
    0.96
    """
    if judged is None:
        return None
    return {
        "before": judged.rms_before,
        "after": judged.rms_after,
        "noise_floor": judged.noise_floor,
        "settled_before": judged.settled_before,
        "settled_after": judged.settled_after,
        "removed_share": judged.removed_share,
        "size_before": judged.size_before,
        "size_after": judged.size_after,
    }


def write_discrepancy(decision: Decision, stated: dict[str, Any], left: dict[str, Any]) -> str:
    """A sentence on how far the model may be off, or has to be so that what comes nearest would do; "" for neither.

    `stated` and `left` are those of `describe_discrepancy` and, of what comes nearest, `describe_left`.
    """
    if stated:
        return f" The model is taken to be good to {format_sizes(stated)}."
    if decision.verdict == Verdict.REFUSED and decision.best and decision.reason.kind in LEAVING:
        size, nearest = format_sizes(left), _capitalise(_list_choices([decision.best]))
        return f' {nearest} comes nearest. If a model that is off by {size} will do, say --tolerance "{size}".'
    return ""


def write_sentence(explanation: "Explanation") -> str:
    """The verdict in a sentence that a technician understands."""
    decision = explanation.decision

    # Verdicts that name nothing, each with a sentence of its own.
    if decision.verdict == Verdict.NO_GAP and explanation.gap_test.alarm:
        return "What the model leaves is more than noise, but too small to matter: nothing is added to it."
    if decision.verdict == Verdict.NO_GAP:
        return "The model explains the data: nothing is missing that these data could show."
    if decision.verdict == Verdict.REFUSED:
        answer = "nothing in the library closes it"
        if decision.reason.kind is ReasonKind.FAINT:
            answer = f"these data hardly show what closes it: {_list_alternatives(decision)}"
        if explanation.tabulated:
            answer += f"; a table of {ARTICLES[explanation.tabulated.balance.balance]} takes it best"
        return f"There is a gap, and {answer}."
    if decision.reason.kind is ReasonKind.ODD_REPEAT:
        return f"The model explains the data if their records are right, but {decision.reason}."
    if decision.verdict == Verdict.AMBIGUOUS and decision.sure:
        return _write_sure(decision)
    if decision.verdict == Verdict.AMBIGUOUS:
        return f"There is a gap, and these data do not show what closes it: {_list_alternatives(decision)}."

    # From here on something is named: effects with their values, and numbers that are wrong besides.
    best = _best(decision).model
    rows = describe_effects(best)
    texts = _format_effects(rows)
    said = " and ".join(texts.values())
    wrong = _write_numbers(describe_numbers(best))

    # Errors of a number or of a record; what the other files say follows on the latter.
    if decision.verdict == Verdict.CALIBRATION:
        record = "".join(f", or the {name.replace('_', ' ')} of the record" for name in _list_same_in_record(decision))
        return f"Nothing is missing, but {_say_wrong(rows)}: {said}{record}."
    if decision.verdict == Verdict.MEASUREMENT:
        faults = [row for row in rows if row["file"]]
        wrong = "; ".join(f"{row['file']}: {format_fault(row)}" for row in faults)
        others = write_sentence(explanation.rest) if explanation.rest else ""
        rest = others and f" Without it, {others[0].lower()}{others[1:]}"
        return f"The record of one file is wrong ({wrong}).{rest}"

    # What the sensors add is a fault of the record, and no lack of the model.
    sensed = _list_sensed(best)
    lacks = " and ".join(text for name, text in texts.items() if name not in sensed)
    recorded = " and ".join(text for name, text in texts.items() if name in sensed)
    if decision.verdict == Verdict.NAMED_CLASS:
        others = " or ".join([_list_choices(decision.rivals), *map(_format_part, _list_same_in_record(decision))])
        if all(candidate.is_file_number for candidate in best.candidates):
            return f"{_capitalise(_say_wrong(rows))}: {said}, or what these data do not distinguish from it: {others}."
        opening = "The gap is" if recorded else "The model lacks"
        return f"{opening} {said}, or what these data do not distinguish from it: {others}.{wrong}"
    if not lacks:
        return f"The model lacks nothing that these data show, but the record has {recorded}.{wrong}"
    if recorded:
        return f"The model lacks {lacks}, and the record has {recorded}.{wrong}"
    number = {Verdict.TWO_EFFECTS: "two effects: ", Verdict.SEVERAL: "several effects: "}.get(decision.verdict, "")
    return f"The model lacks {number}{lacks}.{_write_misstated(rows)}{wrong}"


def _list_sensed(model: Model) -> set[str]:
    """Names of the effects that the sensors alone know."""
    return SENSED | {p.key.split(".")[1] for p in model.residuals.parameters if p.is_sensed}


def _write_sure(decision: Decision) -> str:
    """What is sure of an ambiguous gap, and what may be with it, in sentences."""
    model, rows = _best(decision).model, describe_sure(decision)
    texts, sensed = _format_effects(rows), _list_sensed(model)

    # What is sure, by its kind: effects of the machine, what the sensors add, and numbers of the machine file.
    groups = sorted(decision.sure, key=len)  # a class comes last, as its "or" would take in what stands behind it
    said = {name: _write_either(texts.get(name, _format_part(name)), twins) for name, *twins in groups}
    numbers = {each.name for each in model.candidates if each.is_file_number}
    wrong, effects = [said[name] for name in said if name in numbers], [name for name in said if name not in numbers]
    lacks = " and ".join(said[name] for name in effects if name not in sensed)
    recorded = " and ".join(said[name] for name in effects if name in sensed)
    parts = ["the model lacks " + lacks] * bool(lacks) + ["the record has " + recorded] * bool(recorded)
    sentences = [f"{_capitalise(' and '.join(parts))}.{_write_misstated(rows)}"] if parts else []
    if wrong:
        number = "a number is wrong" if len(wrong) == 1 else f"{len(wrong)} numbers are wrong"
        opening = f"Besides, {number}" if parts else _capitalise(number)
        sentences.append(f"{opening}: {' and '.join(wrong)}.")

    # What each explanation has beside it. Where all have the same, it is the one that is in doubt.
    shared = {name for group in decision.sure for name in group}
    choices = [tuple(n for n in choice.names if n not in shared) for choice in (_best(decision), *decision.rivals)]
    rests = list({frozenset(names): names or NOTHING_ELSE for names in choices}.values())
    if len(rests) > 1:
        it = "it" if len(said) == 1 else "them"
        sentences.append(f"With {it} {_list_names(rests)}, which these data do not distinguish.")
    elif rests == [NOTHING_ELSE]:
        sentences.append(f"The verdict stays open, as {decision.reason}.")
    else:
        sentences.append(f"What else there is, is less sure: {_list_names(rests)}.")
    return " ".join(sentences)


def _write_either(text: str, twins: Sequence[str]) -> str:
    """An effect in words, and behind it what the data do not distinguish from it."""
    return f"either {text} or {' or '.join(map(_format_part, twins))}" if twins else text


def _capitalise(text: str) -> str:
    """A text with a capital at its beginning, all else as it is."""
    return text[0].upper() + text[1:]


def _write_misstated(rows: list[dict[str, Any]]) -> str:
    """A sentence on numbers of the machine file whose errors would do the same as effects; "" where there are none."""
    said = [
        f"{format_key(each['key'])} {each['text']} where the file says {each['before']}"
        for row in rows
        for each in row["misstated"]
    ]
    return f" The same would come of a wrong number: {' and '.join(said)}." if said else ""


def _write_numbers(rows: list[dict[str, Any]]) -> str:
    """A sentence on numbers that are wrong besides, after another one; "" where there are none."""
    if not rows:
        return ""
    return f" Besides, {_say_wrong(rows)}: {' and '.join(_format_effects(rows).values())}."


def _say_wrong(rows: list[dict[str, Any]]) -> str:
    """That readings or numbers are wrong, in words."""
    kinds = {"reading" if row["key"].startswith(READINGS) else "number" for row in rows}
    [kind] = kinds if len(kinds) == 1 else ["number"]
    return f"a {kind} is wrong" if len(rows) == 1 else f"{len(rows)} {kind}s are wrong"


def format_fault(row: dict[str, Any]) -> str:
    """A fault of measurement of one file, a row of `describe_effects`, in words.

    >>> late = {"name": "run_time_zero", "key": "effects.time_zero.time", "value": 10.0, "unit": "ms"}
    >>> format_fault(late), format_fault(late | {"value": -0.5})
    ('recorded 10 ms late', 'recorded 0.50 ms early')
    """
    value = row["value"]
    if row["key"].startswith(READINGS):
        return _format_effect(row["name"], [row | {"open_ends": []}])
    if row["name"] == FaultKind.SWAP:
        swapped = value > 0.5
        return f"pressures of both chambers are {'swapped' if swapped else f'mixed by {_format_shift(row, 100.0)} %'}"
    if row["name"] == FaultKind.CLOCK:
        return f"its clock is {_format_shift(row, 100.0)} % {'fast' if value > 0.0 else 'slow'}"
    return f"recorded {_format_shift(row)} {row['unit']} {'late' if value > 0.0 else 'early'}"


def _format_shift(row: dict[str, Any], factor: float = 1.0) -> str:
    """Absolute value of a parameter times a factor, with the digits that its interval leaves."""
    error = find_error(row["value"], row.get("interval_95"), row.get("open_ends", ()))
    return round_to_error(factor * abs(row["value"]), None if error is None else factor * error)


def _list_alternatives(decision: Decision) -> str:
    """The best explanation and its rivals in words."""
    return _list_choices((_best(decision), *decision.rivals))


def _list_choices(choices: Sequence[PricedModel]) -> str:
    """Explanations in words; of many the first, and how many others there are."""
    return _list_names([choice.names for choice in choices])


def _list_names(choices: Sequence[Sequence[str]]) -> str:
    """Explanations, each by the names of its parts, in words; of many the first, and how many others there are."""
    listed = [" with ".join(map(_format_part, names)) for names in choices[:MAX_LISTED]]
    if len(choices) > MAX_LISTED:
        listed.append(f"one of {len(choices) - MAX_LISTED} others")
    return ", or ".join(listed)


def _format_part(name: str) -> str:
    """An effect, a fault of a file or a key of the machine in words."""
    kind, found, file = name.partition(" in ")
    return format_key(kind).replace(",", "") + found + file


def describe_added(rows: list[dict[str, Any]]) -> dict[str, str]:
    """What an explanation adds, in words: effects with their values, and faults with their files.

    The rows are those of `describe_effects`; the texts go by the name of the effect, or by the file and the kind of its
    fault.

    >>> late = {"name": "run_time_zero", "key": "effects.time_zero.time", "value": 10.2, "unit": "ms", "file": "a.csv"}
    >>> describe_added([late | {"parameter": "time", "interval_95": [9.0, 11.4], "open_ends": []}])
    {'a.csv run_time_zero': 'a.csv: recorded 10.2 ms late'}
    """
    faults = {f"{row['file']} {row['name']}": f"{row['file']}: {format_fault(row)}" for row in rows if row["file"]}
    return _format_effects([row for row in rows if not row["file"]]) | faults


def _format_effects(rows: list[dict[str, Any]]) -> dict[str, str]:
    """Each effect with its values in words, by its name; readings by their keys, as two gains are two of them."""
    by_name: dict[str, list[dict[str, Any]]] = {}
    for row in rows:
        by_name.setdefault(row["key"] if row["key"].startswith(READINGS) else row["name"], []).append(row)
    return {name: _format_effect(name, own_rows) for name, own_rows in by_name.items()}


def _format_effect(name: str, rows: list[dict[str, Any]]) -> str:
    """An effect, a number of the machine or a reading, with its values."""
    row = rows[0]
    if row["key"].startswith(READINGS):
        factor, unit = (1.0, row["unit"]) if row["unit"] else (100.0, "%")
        way = "high" if row["value"] > 0.0 else "low"
        return f"{row['parameter'].replace('_', ' ')} reads {_format_shift(row, factor)} {unit} too {way}"
    values = [("" if one["key"] == name else f"{_format_part(one['parameter'])} ", format_value(one)) for one in rows]
    said = ", ".join(parameter + value for parameter, value in values if value)
    if row.get("before"):
        said += f", where the file says {row['before']}"
    return f"{format_key(name)} ({said})"
