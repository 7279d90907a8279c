"""Findings as plain data: what ``verdict.json`` holds."""

from math import sqrt

import numpy as np

from apesim.studies.estimation.parameters import SENSED, value_at
from apesim.studies.gap.decide.operating_points import label_of
from apesim.studies.gap.decide.verdict import (
    AMBIGUOUS_VERDICT,
    CALIBRATION,
    FAINT,
    NAMED,
    NAMED_CLASS,
    NO_GAP,
    REFUSED,
    TWO_EFFECTS,
    refusal,
)
from apesim.studies.gap.report.effect_rows import effects_of, value_text
from apesim.studies.gap.search.detection_limits import detection_limits

ARTICLES = {"force": "a force", "heat": "heat", "leak": "leaks", "area": "a flow area", "delay": "a delay"}
"""The balances in a sentence."""
READINGS = "effects.sensor_offset.", "effects.sensor_gain."
"""Keys of what an instrument reads too much."""


def record(findings):
    """The content of ``verdict.json``.

    Parameters
    ----------
    findings : apesim.studies.gap.workflow.Findings

    Returns
    -------
    dict
        But for what the command adds: ``lineage``, ``wall_time_s``.
    """
    verdict = findings.verdict
    cells = findings.cells if findings.detection.alarm else []
    named = verdict.verdict in (NAMED, NAMED_CLASS, TWO_EFFECTS, CALIBRATION)
    found = effects_of(verdict.best.model) if verdict.best else []
    rivals = [
        {
            "effects": list(choice.names),
            "cost": choice.cost - verdict.best.cost,
            "parameters": effects_of(choice.model),
        }
        for choice in verdict.rivals
    ]
    return {
        "verdict": verdict.verdict,
        "sentence": sentence(findings),
        "reason": verdict.reason,
        "effects": found if named else [],
        "nearest": [] if named else found,
        "class": [*verdict.best.names, *(name for c in verdict.rivals for name in c.names)] if named else [],
        "alternatives": rivals,
        "probability": None,  # stated once it is calibrated
        "alarm": findings.detection.alarm,
        "p_value": findings.detection.p_value,
        "largest_score": findings.detection.largest,
        "gap": gap_of(findings.base, findings.best),
        "held_out": held_out_of(findings.checked),
        "gates": held_out_of(findings.judged),
        "localised": {
            "signal": cells[0].signal if cells else None,
            "phase": cells[0].phase if cells else None,
            "size": findings.size,
            "balance": findings.balances[0].balance if findings.balances else None,
            "balances": [balance_of(balance) for balance in findings.balances],
            "shares": [cell._asdict() for cell in cells if cell.share > 0.01],
        },
        "tabulated": tabulated_of(findings) if findings.tabulated else None,
        "detection_limits": detection_limits(findings.columns),
        "scores": [{"effect": score.name, "deviations": score.deviations} for score in findings.scores],
        "nuisances": nuisances_of(findings),
        "noise": noise_told(findings.noise),
        "own_error": findings.own_error,
        "tolerance": findings.tolerance,
        "simulations": findings.simulations,
        "warnings": findings.warnings,
    }


def nuisances_of(findings):
    """What the calibration moved, the farthest first; ``apart``: which operating point alone leads farthest from it."""
    model = findings.best
    machine, apart = model.problem.machine, {one.parameter.key: one for one in findings.apart}
    rows = [
        {
            "key": p.key,
            "value": p.shown(value_at(machine, p, x)),
            "unit": p.declaration.unit,
            "deviations": float(x),
            "apart": apart_of(apart[p.key], machine) if p.key in apart else None,
        }
        for p, x in zip(model.problem.parameters, model.fitted.x, strict=True)
        if p.prior
    ]
    return sorted(rows, key=lambda row: -abs(row["deviations"]))


def apart_of(one, machine):
    """Return where an operating point alone leads a number."""
    value = one.parameter.shown(value_at(machine, one.parameter, one.x))
    return {"run": label_of(one.run, machine.ambient.pressure), "value": value, "deviations": float(one.deviations)}


def gap_of(base, best):
    """The gap on the fitted runs, root mean squares over the noise."""
    before, after = base.fitted.left, best.fitted.left
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


def tabulated_of(findings):
    """The table that was added in place of a law."""
    tabulated, base = findings.tabulated, findings.base
    refused = refusal(tabulated.judged, findings.tolerance) if tabulated.judged else ""
    return {
        "kind": tabulated.balance.name,
        "balance": tabulated.balance.balance,
        "parameters": effects_of(tabulated.model),
        "gap": gap_of(base, tabulated.model),
        "held_out": held_out_of(tabulated.judged),
        "verified": not refused if tabulated.judged else None,
        "reason": refused,
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


def sentence(findings):
    """The verdict in a sentence that a technician understands."""
    verdict = findings.verdict
    if verdict.verdict == NO_GAP and findings.detection.alarm:
        return "What the model leaves is more than noise, but too small to matter: nothing is added to it."
    if verdict.verdict == NO_GAP:
        return "The model explains the data: nothing is missing that these data could show."
    if verdict.verdict == REFUSED:
        said = "nothing in the library closes it"
        if verdict.reason == FAINT:
            said = f"these data hardly tell what closes it: {_either(verdict)}"
        if findings.tabulated:
            said += f"; a table of {ARTICLES[findings.tabulated.balance.balance]} takes it best"
        return f"There is a gap, and {said}."
    if verdict.verdict == AMBIGUOUS_VERDICT:
        return f"There is a gap, and these data do not tell what closes it: {_either(verdict)}."
    rows = effects_of(verdict.best.model)
    texts = _told(rows)
    said = " and ".join(texts.values())
    if verdict.verdict == CALIBRATION:
        wrong = "reading" if rows[0]["key"].startswith(READINGS) else "number"
        return f"Nothing is missing, but a {wrong} is wrong: {said}."
    lacks = " and ".join(text for name, text in texts.items() if name not in SENSED)
    recorded = " and ".join(text for name, text in texts.items() if name in SENSED)
    if verdict.verdict == NAMED_CLASS:
        others = " or ".join(name.replace("_", " ") for choice in verdict.rivals for name in choice.names)
        opening = "The gap is" if recorded else "The model lacks"
        return f"{opening} {said}, or what these data do not tell from it: {others}."
    if not lacks:
        return f"The model lacks nothing that these data show, but the record has {recorded}."
    if recorded:
        return f"The model lacks {lacks}, and the record has {recorded}."
    return f"The model lacks {'two effects: ' if verdict.verdict == TWO_EFFECTS else ''}{lacks}."


def _either(verdict):
    """The best explanation and its rivals in words."""
    return ", or ".join(" with ".join(c.names) for c in (verdict.best, *verdict.rivals)).replace("_", " ")


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
