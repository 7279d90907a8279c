"""Next test: the experiment that would tell most between the explanations that these data leave open."""

from collections.abc import Sequence
from math import ceil
from typing import TYPE_CHECKING, Any

from apesim.studies.estimation.residuals import unless_ended
from apesim.studies.estimation.scatter import list_odd_repeats
from apesim.studies.gap.design.deciding_trace import find_deciding_trace
from apesim.studies.gap.design.expected_information import find_entropy, find_information, find_separation
from apesim.studies.gap.design.experiments import Experiment, describe_run, list_experiments
from apesim.studies.gap.design.forecasts import Alternative, Preview, list_alternatives, preview_experiment
from apesim.studies.gap.design.outcomes import describe_outcomes, write_outcomes
from apesim.studies.gap.reasons import ReasonKind, Verdict
from apesim.studies.gap.report.effect_rows import describe_pulled, format_value
from apesim.studies.gap.report.engine_curve import is_speed_curve
from apesim.studies.gap.report.verdict_json import READINGS, describe_added
from apesim.studies.gap.report.words import format_key, format_name
from apesim.studies.gap.search.detection_limits import find_detection_limits
from apesim.studies.gap.search.library import list_effects
from apesim.studies.gap.search.run_faults import find_files
from apesim.studies.gap.thresholds import N_SIGMA_VISIBLE
from apesim.studies.measured import CYLINDER, FIT, GATE, Role

if TYPE_CHECKING:
    from apesim.studies.gap.explanation import Explanation

MAX_EXPERIMENTS = 5
"""Experiments that are foreseen with sensitivities of each explanation's own, those that tell most by a cheaper
estimate: each costs seconds."""
MAX_EFFECTS = 3
"""Effects whose own experiment is named: more would not be read."""
MAX_MEASURED = 3
"""Far numbers of the machine that are named to be measured, the farthest ones: more would not be read."""
MAX_REPEATS = 100
"""Repeats of an experiment above which it is no advice."""
NOT_SHOWN = ReasonKind.REMOVES_NOTHING, ReasonKind.GAP_STILL_THERE
"""Reasons of a refusal by runs that nothing was fitted to, which may hardly show what was tried."""
MIN_SETTLED = 0.1
"""Share of what is open that an experiment has to settle to be advised without a word of doubt."""
DECIDES = 0.5
"""Share of what is open that an experiment is expected to settle, so that none beyond what was run is looked at."""
STEP_SETTLED = 0.05
"""Share of what is open by which one experiment has to settle more than another to count as better: draws err by half
of it. Of two alike, the one that keeps its explanations farther apart is taken."""


def find_next_test(explanation: "Explanation") -> dict[str, Any]:
    """Find the next test, as text and data.

    Where explanations are to be split, the data are what `rank_experiments` gives; ``isolate`` holds the library's own
    experiment for effects. Means over the speed alone have ``trace``, too, see `find_deciding_trace`.
    """
    test = _choose_test(explanation)
    if explanation.scores and is_speed_curve(explanation.measured):
        test |= {"trace": find_deciding_trace(explanation, test)}
    return test


def _choose_test(explanation: "Explanation") -> dict[str, Any]:
    """The next test by the verdict."""
    decision = explanation.decision

    # Nothing to choose an experiment by: the library was not tried, or a record has to be looked at first.
    if not explanation.scores:
        return {"text": "The same again, with the library: nothing of it was tried.", "isolate": []}
    if decision.reason.kind is ReasonKind.ODD_REPEAT:
        files = " and ".join(list_odd_repeats(explanation.best.residuals.scatter))
        return {"text": f"Look at the record of {files}, and record its operating point once more.", "isolate": []}

    # Several explanations are open: experiments are ranked by how far they split them. After a refusal the
    # library's own experiments for the effects of the highest scores stand beside, and numbers that are far off are to
    # be measured first: no run tells as surely whether they are wrong, or have taken up what is missing.
    if decision.verdict in (Verdict.AMBIGUOUS, Verdict.NAMED_CLASS):
        return rank_experiments(explanation)
    if decision.verdict == Verdict.REFUSED:
        ranked = rank_experiments(explanation)
        if first := _write_measurements(explanation):
            ranked |= {key: f"{first} Then: {ranked[key][0].lower()}{ranked[key][1:]}" for key in ("text", "action")}
        return ranked | _isolate(explanation, [score.name for score in explanation.scores])

    # A wrong record comes first, whatever the other files ask for.
    if explanation.rest:
        files = " and ".join(find_files(explanation.best.candidates))
        rest, again = _choose_test(explanation.rest), f"Record {files} again, or leave it out."
        if explanation.rest.verdict == Verdict.NO_GAP:
            return rest | {"text": again}
        return rest | {"text": f"{again} Then: {rest['text'][0].lower()}{rest['text'][1:]}"}

    # Nothing is open: a number to measure in another way, effects that stay hidden, or what is named, each by itself.
    names = list(decision.best.names) if decision.best else []
    if decision.verdict == Verdict.CALIBRATION:
        text = f"Measure it with another instrument, or in another way: {format_key(names[0])}."
        return {"text": text, "isolate": []}
    if decision.verdict == Verdict.NO_GAP:
        limits = find_detection_limits(explanation.sensitivities)
        effects = list_effects(explanation.calibrated.residuals.machine)  # a number of the machine file has no test
        names = [name for name, limit in limits.items() if limit["limit"] is None and name in effects]
        if not names:
            return {"text": "None is due: every effect of the library would have been seen.", "isolate": []}
        opening = "None is due for what these data show. What they cannot show needs its own test"
    else:
        opening = "To see it by itself"
    isolated = _isolate(explanation, names)
    ways = "; ".join(f"{row['effect'].replace('_', ' ')}: {row['isolated_by']}" for row in isolated["isolate"])
    return {"text": f"{opening}: {ways}."} | isolated


def _write_measurements(explanation: "Explanation") -> str:
    """What to measure, or to check, as the explanation that was refused pulls it far; "" where it pulls nothing."""
    best = explanation.decision.best
    rows = describe_pulled(best.model if best else explanation.best)
    sentences = [_write_measurement(row) for row in rows[:MAX_MEASURED]]
    if (more := len(rows) - MAX_MEASURED) > 0:
        sentences.append(f"{more} more number{'s are' if more > 1 else ' is'} far off, too.")
    return " ".join(sentences)


def _write_measurement(row: dict[str, Any]) -> str:
    """What to measure in another way, or which sensor to check, by a row of `describe_pulled`."""
    before = row["before"]
    if not row["key"].startswith(READINGS):
        name, asked = format_key(row["key"]).replace(",", ""), f"the data ask for {format_value(row)}"
        return f"Measure {name} in another way: {asked}, the machine file says {before}."
    part, sensor = "zero", format_name(row["parameter"])
    if row["key"].startswith("effects.sensor_gain."):
        part, share = "gain", 100.0 * float(before)
        before = f"{share:+g} %" if share else "0 %"
    [text] = describe_added([row]).values()
    return f"Check the {part} of the {sensor} sensor: by the data {text}, the machine file says {before}."


def _isolate(explanation: "Explanation", names: Sequence[str]) -> dict[str, Any]:
    """The library's own experiment for the first of some effects, as ``isolate``."""
    isolated = {}
    for name, entry in list_effects(explanation.calibrated.residuals.machine).items():
        on_rig = entry.isolated_on_rig if explanation.measured.bench == CYLINDER else ""
        isolated[name] = on_rig or entry.isolated_by
    rows = [{"effect": name, "isolated_by": isolated[name]} for name in names if name in isolated]
    return {"isolate": rows[:MAX_EFFECTS]}


def rank_experiments(explanation: "Explanation") -> dict[str, Any]:
    """Rank the experiments by what they are expected to tell between the explanations that are in play.

    `explanation` is a tie or a refusal. All of the list are foreseen cheaply, with one set of sensitivities, the best
    `MAX_EXPERIMENTS` between the runs that there are then with those of each explanation, and as many beyond them where
    none of these is expected to settle the share `DECIDES`; ``others`` are those foreseen cheaply alone. ``truth`` is
    the leading explanation, ``entropy_bits`` what is open, ``action`` what to do; each of ``experiments``, the best
    first, is as `describe_run` gives it, with ``role``, ``information_bits``, ``settled`` (its share of what is open),
    ``deviations`` by which each rival would miss what the truth gives, ``least`` of them, and ``outcomes``.
    """
    alternatives = list_alternatives(explanation)
    weights = [alternative.weight for alternative in alternatives]
    entropy = find_entropy(weights)
    ambient = explanation.calibrated.residuals.machine.ambient.pressure

    # All of the list with one set of sensitivities: with those of each explanation every one would take seconds.
    listed = list_experiments(explanation.measured, ambient)
    screened = []
    for experiment in listed:
        preview = unless_ended(_preview, experiment, explanation, alternatives, False)
        if preview:
            screened.append((find_information(preview.forecasts, weights), experiment))
    screened.sort(key=lambda row: -row[0])

    # The best of them in full; what lies beyond the runs that there are is looked at only where none within decides.
    # Shares settled count in steps, as draws err: of two alike the one is better that keeps its explanations farther
    # apart.
    role = choose_role(explanation)
    rows: list[dict[str, Any]] = []
    taken: list[Experiment] = []
    for is_within in (True, False):
        if any(row["settled"] >= DECIDES for row in rows):
            break
        part = [experiment for _, experiment in screened if experiment.is_within == is_within][:MAX_EXPERIMENTS]
        previews = [unless_ended(_preview, experiment, explanation, alternatives, True) for experiment in part]
        told = [_describe_experiment(preview, alternatives, entropy) for preview in previews if preview]
        rows += [row | {"role": str(role)} for row in told]
        taken += part
    rows.sort(key=lambda row: (-round(row["settled"] / STEP_SETTLED), -row["least"]))

    # The advice in words, and all that it rests on as data.
    action = _write_action(rows, role)
    return {
        "text": " ".join([action, *(write_outcomes(row["outcomes"]) for row in rows[:1])]),
        "action": action,
        "truth": alternatives[0].name,
        "explanations": [{"name": each.name, "weight": each.weight} for each in alternatives],
        "entropy_bits": entropy,
        "experiments": rows,
        "others": [
            describe_run(experiment) | {"role": str(role), "information_bits": information}
            for information, experiment in screened
            if not any(experiment is each for each in taken)
        ],
    }


def choose_role(explanation: "Explanation") -> Role:
    """Choose the role of a further run: a gate where too little of the gap was removed on gate runs, else fitted.

    In the first case those gates decide alone, however much is fitted.
    """
    decision = explanation.decision
    by_gates = decision.verdict == Verdict.REFUSED and decision.reason.kind in NOT_SHOWN
    return GATE if by_gates and explanation.measured.of(GATE) else FIT


def _preview(experiment: Any, explanation: "Explanation", alternatives: Sequence[Alternative], refine: bool) -> Preview:
    """Foresee an experiment, see `preview_experiment`."""
    return preview_experiment(experiment, explanation, alternatives, refine=refine)


def _describe_experiment(preview: Preview, alternatives: Sequence[Alternative], entropy: float) -> dict[str, Any]:
    """What an experiment would tell, as data."""
    information = find_information(preview.forecasts, [alternative.weight for alternative in alternatives])
    rivals = zip(alternatives[1:], preview.forecasts[1:], strict=True)
    n_sigma = {rival.name: find_separation(preview.forecasts[0], forecast) for rival, forecast in rivals if rival.model}
    return describe_run(preview.experiment) | {
        "information_bits": information,
        "settled": information / entropy if entropy else 0.0,
        "deviations": n_sigma,
        "least": min(n_sigma.values(), default=0.0),
        "outcomes": describe_outcomes(preview, alternatives),
    }


def _write_action(rows: list[dict[str, Any]], role: Role) -> str:
    """What to do next, by the best of the experiments."""
    if not rows:
        return "No experiment of the list could be simulated."
    best = rows[0]
    action = f"Make {best['text']}: it is expected to settle {100.0 * best['settled']:.0f} % of what is open."
    repeats = ceil((N_SIGMA_VISIBLE / max(best["least"], 1e-3)) ** 2)
    if best["settled"] < MIN_SETTLED and repeats > MAX_REPEATS:
        action = (
            "No run of the list, and no sensor, would decide. What comes nearest: " + action[0].lower() + action[1:]
        )
    elif 1 < repeats <= MAX_REPEATS:
        action += f" One run leaves some of them less than {N_SIGMA_VISIBLE:g} sigmas apart: make {repeats}."
    if role == GATE:
        action += f" Give it the role {GATE}: the refusal is by runs of this role, which may hardly show what is asked."
    return action
