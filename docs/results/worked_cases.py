"""Data from the independent simulator with an effect hidden in each set: what is found, and with less friction."""

from pathlib import Path
from tempfile import TemporaryDirectory

import apesim
from docs.examples.data.missing_effect import make
from docs.results import Number, Table
from docs.results._figures import keep

LONG = True
DOCS = Path(__file__).parent.parent
HIDDEN = {
    "coulomb": ("Coulomb friction, 6 N", "lift, both chambers", "coulomb_friction"),
    "solenoid": ("solenoid B late by 0.3 ms", "lift, both chambers", "solenoid_b_delay"),
    "coulomb_lift_alone": ("Coulomb friction, 6 N", "lift at 0.40 MPa gauge alone", "coulomb_friction"),
}
FIGURES = {
    ("coulomb", "maps"): DOCS / "missing_effect" / "worked_coulomb.png",
    ("solenoid", "overlays"): DOCS / "missing_effect" / "worked_solenoid.png",
    ("solenoid", "maps"): DOCS / "missing_effect.png",
}
"""Figures of the reports that the pages show, by case and name."""
LESS = 1.0, 2.5, 4.0
"""Coulomb friction of the same rig in further sets [N]."""
MAX_SCORES = 4
ERRORS = {"N": 0.05, "ms": 0.0005}
HEADS = [
    "hidden",
    "measured",
    "verdict",
    "found, with 95 % interval",
    "gap over the noise at 0.49 MPa gauge, before",
    "after",
    "by noise alone",
]


def compute():
    """What is found in each set, the best scores, and from which size on these data show the hidden effect."""
    values, rows = {}, []
    for name, (hidden, measured, effect) in HIDDEN.items():
        found = apesim.explain(apesim.Machine(), make.HERE / name)
        rows.append([hidden, measured, f"`{found.verdict}`", describe(found), *describe_check(found)])
        for key, value in describe_case(found, effect).items():
            values[f"{name}.{key}"] = value
        draw(found, name)
    return values | {"cases": Table(HEADS, rows), "less_friction": find_less_friction()}


def describe(found):
    """Each parameter that is found, with its interval; where nothing is named, the explanations that are left."""
    texts = []
    if found.verdict == "AMBIGUOUS":
        left = [found.decision.best, *found.decision.rivals]
        return " or ".join(" with ".join(f"`{name}`" for name in choice.names) for choice in left)
    for row in found.effects:
        low, high = row["interval_95"]
        value, interval = f"{row['value']:.3g} {row['unit']}", f"{low:.3g} to {high:.3g} {row['unit']}"
        shown = f"at most {high:.3g} {row['unit']}" if "low" in row["open_ends"] else f"{value} ({interval})"
        texts.append(f"`{row['name']}.{row['parameter']}` {shown}")
    return "; ".join(texts) or "nothing"


def describe_check(found):
    """The gap over the noise on the check run: before, after, and what noise alone leaves."""
    if not found.held_out:
        return ["nothing was held out", "–", "–"]
    return [Number(found.held_out[key], error=0.0005) for key in ("before", "after", "noise_floor")]


def describe_case(found, effect):
    """Numbers of a case, by name; those of detection are of the effect that is hidden."""
    limits = found.detection_limits
    invisible = [[f"`{name}`"] for name, row in limits.items() if row["limit"] is None]
    scores = [[f"`{score.name}`", Number(score.n_sigma, error=0.05)] for score in found.scores[:MAX_SCORES]]
    values = {
        "p_value": Number(found.gap_test.p_value, error=0.005),
        "visible_from": Number(limits[effect]["limit"], limits[effect]["unit"], error=ERRORS[limits[effect]["unit"]]),
        "retained": Number(100.0 * limits[effect]["kept"], "%", error=0.5),
        "scores": Table(["effect", "score [sigmas]"], scores),
        "invisible": Table(["effects that these data cannot show"], invisible),
    }
    if found.held_out:
        values["check_before"], values["check_after"], _ = describe_check(found)
    for row in found.effects:
        error = ERRORS[row["unit"]]
        values[row["parameter"]] = Number(row["value"], row["unit"], error)
        values[f"{row['parameter']}.low"], values[f"{row['parameter']}.high"] = (
            Number(end, row["unit"], error) for end in row["interval_95"]
        )
    return values


def draw(found, name):
    """Take the figures that the pages show from the report of a case."""
    wanted = {figure: path for (case, figure), path in FIGURES.items() if case == name}
    if wanted:
        keep(found.write, **wanted)


def find_less_friction():
    """What is found where the same rig has less Coulomb friction, with other noise in each set."""
    rows = []
    for seed, force in enumerate(LESS, 1960):
        rig = make.RIG._replace(dry_friction=force, breakaway=force)
        with TemporaryDirectory() as folder:
            make.write_folder(
                Path(folder), rig, make.RUNS, chambers=True, reading=make.Reading(1.004, 0.01e-3), seed=seed
            )
            found = apesim.explain(apesim.Machine(), folder)
            rows.append([Number(force, "N", error=0.05), f"`{found.verdict}`", describe(found), found.reason])
    return Table(["hidden [N]", "verdict", "found, with 95 % interval", "reason"], rows)
