"""An explanation as plain data: what ``verdict.json`` holds."""

from math import sqrt

import numpy as np

from apesim.studies.estimation.parameters import SENSED, value_at
from apesim.studies.gap.decide.operating_points import label_of
from apesim.studies.gap.decide.verdict import refusal
from apesim.studies.gap.reasons import NAMING, ReasonKind, Verdict
from apesim.studies.gap.report.effect_rows import effects_of, value_text
from apesim.studies.gap.search.detection_limits import detection_limits

ARTICLES = {"force": "a force", "heat": "heat", "leak": "leaks", "area": "a flow area", "delay": "a delay"}
"""The balances in a sentence."""
READINGS = "effects.sensor_offset.", "effects.sensor_gain."
"""Keys of what an instrument reads too much."""


def describe(explanation):
    """The content of ``verdict.json``.

    Parameters
    ----------
    explanation : apesim.studies.gap.explanation.Explanation

    Returns
    -------
    dict
        Without ``lineage``, ``next_test`` and ``wall_time_s``.
    """
    decision = explanation.decision
    cells = explanation.cells if explanation.gap_test.alarm else []
    named = decision.verdict in NAMING
    found = effects_of(decision.best.model) if decision.best else []
    rivals = [
        {
            "effects": list(choice.names),
            "cost": choice.cost - decision.best.cost,
            "parameters": effects_of(choice.model),
        }
        for choice in decision.rivals
    ]
    return {
        "verdict": str(decision.verdict),
        "sentence": sentence(explanation),
        "reason": str(decision.reason),
        "effects": found if named else [],
        "nearest": [] if named else found,
        "class": [*decision.best.names, *(name for c in decision.rivals for name in c.names)] if named else [],
        "alternatives": rivals,
        "probability": None,  # stated once it is calibrated
        "alarm": explanation.gap_test.alarm,
        "p_value": explanation.gap_test.p_value,
        "largest_score": explanation.gap_test.largest,
        "gap": gap_of(explanation.calibrated, explanation.best),
        "held_out": held_out_of(explanation.checked),
        "gates": held_out_of(explanation.judged),
        "localised": {
            "signal": cells[0].signal if cells else None,
            "phase": cells[0].phase if cells else None,
            "size": explanation.gap_size,
            "balance": explanation.balances[0].balance if explanation.balances else None,
            "balances": [balance_of(balance) for balance in explanation.balances],
            "shares": [cell._asdict() for cell in cells if cell.share > 0.01],
        },
        "tabulated": tabulated_of(explanation) if explanation.tabulated else None,
        "detection_limits": detection_limits(explanation.sensitivities),
        "scores": [{"effect": score.name, "deviations": score.deviations} for score in explanation.scores],
        "nuisances": nuisances_of(explanation),
        "noise": noise_told(explanation.noise),
        "own_error": explanation.solver_error,
        "tolerance": explanation.tolerance,
        "simulations": explanation.simulations,
        "warnings": explanation.warnings,
    }


def nuisances_of(explanation):
    """What the calibration moved, the farthest first; ``apart``: which operating point alone leads farthest from it."""
    model = explanation.best
    machine, apart = model.residuals.machine, {one.parameter.key: one for one in explanation.consistency}
    rows = [
        {
            "key": p.key,
            "value": p.shown(value_at(machine, p, x)),
            "unit": p.declaration.unit,
            "deviations": float(x),
            "apart": apart_of(apart[p.key], machine) if p.key in apart else None,
        }
        for p, x in zip(model.residuals.parameters, model.fitted.x, strict=True)
        if p.prior
    ]
    return sorted(rows, key=lambda row: -abs(row["deviations"]))


def apart_of(one, machine):
    """Return where an operating point alone leads a number."""
    value = one.parameter.shown(value_at(machine, one.parameter, one.x))
    return {"run": label_of(one.run, machine.ambient.pressure), "value": value, "deviations": float(one.deviations)}


def gap_of(base, best):
    """The gap on the fitted runs, root mean squares over the noise."""
    before, after = base.fitted.data_residuals, best.fitted.data_residuals
    n = len(before)
    return {
        "before": float(np.sqrt(before @ before / n)),
        "after": float(np.sqrt(after @ after / n)),
        "noise_floor": sqrt(max(0.0, 1.0 - len(base.fitted.x) / n)),
    }


def balance_of(balance):
    """What a table takes of the gap by the straight model."""
    return {
        "balance": balance.balance,
        "table": balance.name,
        "deviations": sqrt(max(0.0, balance.fall)),
        "gain": balance.gain,
    }


def tabulated_of(explanation):
    """The table that was added in place of a law."""
    tabulated, base = explanation.tabulated, explanation.calibrated
    refused = refusal(tabulated.judged, explanation.tolerance) if tabulated.judged else None
    return {
        "kind": tabulated.balance.name,
        "balance": tabulated.balance.balance,
        "parameters": effects_of(tabulated.model),
        "gap": gap_of(base, tabulated.model),
        "held_out": held_out_of(tabulated.judged),
        "verified": not refused if tabulated.judged else None,
        "reason": str(refused or ""),
        "suggestion": tabulated.suggestion,
    }


def noise_told(noise):
    """The noise of each sensor, at each sampling interval."""
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


def held_out_of(judged):
    """The gap on runs that nothing was fitted to; None where there are none."""
    if judged is None:
        return None
    return {
        "before": judged.before,
        "after": judged.after,
        "noise_floor": judged.noise_floor,
        "settled_before": judged.settled_before,
        "settled_after": judged.settled_after,
        "removed_share": judged.share,
        "size_before": judged.size_before,
        "size_after": judged.size,
    }


def sentence(explanation):
    """The verdict in a sentence that a technician understands."""
    decision = explanation.decision
    if decision.verdict == Verdict.NO_GAP and explanation.gap_test.alarm:
        return "What the model leaves is more than noise, but too small to matter: nothing is added to it."
    if decision.verdict == Verdict.NO_GAP:
        return "The model explains the data: nothing is missing that these data could show."
    if decision.verdict == Verdict.REFUSED:
        said = "nothing in the library closes it"
        if decision.reason.kind is ReasonKind.FAINT:
            said = f"these data hardly tell what closes it: {_either(decision)}"
        if explanation.tabulated:
            said += f"; a table of {ARTICLES[explanation.tabulated.balance.balance]} takes it best"
        return f"There is a gap, and {said}."
    if decision.verdict == Verdict.AMBIGUOUS:
        return f"There is a gap, and these data do not tell what closes it: {_either(decision)}."
    rows = effects_of(decision.best.model)
    texts = _told(rows)
    said = " and ".join(texts.values())
    if decision.verdict == Verdict.CALIBRATION:
        wrong = "reading" if rows[0]["key"].startswith(READINGS) else "number"
        return f"Nothing is missing, but a {wrong} is wrong: {said}."
    sensed = SENSED | {p.key.split(".")[1] for p in decision.best.model.residuals.parameters if p.is_sensed}
    lacks = " and ".join(text for name, text in texts.items() if name not in sensed)
    recorded = " and ".join(text for name, text in texts.items() if name in sensed)
    if decision.verdict == Verdict.NAMED_CLASS:
        others = " or ".join(name.replace("_", " ") for choice in decision.rivals for name in choice.names)
        opening = "The gap is" if recorded else "The model lacks"
        return f"{opening} {said}, or what these data do not tell from it: {others}."
    if not lacks:
        return f"The model lacks nothing that these data show, but the record has {recorded}."
    if recorded:
        return f"The model lacks {lacks}, and the record has {recorded}."
    return f"The model lacks {'two effects: ' if decision.verdict == Verdict.TWO_EFFECTS else ''}{lacks}."


def _either(decision):
    """The best explanation and its rivals in words."""
    return ", or ".join(" with ".join(c.names) for c in (decision.best, *decision.rivals)).replace("_", " ")


def _told(rows):
    """What is said of each effect in a sentence, to the digits that can be read, by its name."""
    found: dict = {}
    for row in rows:
        found.setdefault(row["name"], []).append(row)
    return {name: _in_words(name, own) for name, own in found.items()}


def _in_words(name, rows):
    """An effect, a number of the machine or a reading, with its values."""
    row = rows[0]
    if row["key"].startswith(READINGS):
        value, unit = (row["value"], row["unit"]) if row["unit"] else (100.0 * row["value"], "%")
        way = "high" if value > 0.0 else "low"
        return f"{row['parameter'].replace('_', ' ')} reads {abs(value):.3g} {unit} too {way}"
    values = [("" if one["key"] == name else f"{one['parameter']} ", value_text(one)) for one in rows]
    said = ", ".join(parameter + value for parameter, value in values if value)
    return f"{name.replace('_', ' ').replace('.', ', ')} ({said})"
