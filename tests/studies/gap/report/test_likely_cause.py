"""The most likely cause of a gap that is not named, in the verdict and on the terminal."""

from dataclasses import replace

import pytest

from apesim.studies.commands.gap.explain import _shown
from apesim.studies.gap.example_bench import explain_example
from apesim.studies.gap.reasons import ReasonKind, Verdict
from apesim.studies.gap.report.likely_cause import NOTHING_HELPS, SEE_WARNINGS, describe_cause
from apesim.studies.gap.report.verdict_json import describe

REASON = ReasonKind.GAP_LEFT.with_facts(size=0.5)
SAID = {"side_force": "side force (force 3.1 N)"}


def refused(**more):
    found = explain_example()
    return replace(found, decision=found.decision._replace(verdict=Verdict.REFUSED, reason=REASON), **more)


def test_it_is_what_explains_best_with_the_gap_that_it_would_take_away():
    cause = describe_cause(refused(), SAID)
    gap = explain_example().gap
    assert (cause["text"], cause["before"], cause["after"]) == (*SAID.values(), gap["before"], gap["after"])
    assert cause["why_not"] == str(REASON)


@pytest.mark.parametrize(("warnings", "text"), [([], NOTHING_HELPS), (["p.csv: odd"], SEE_WARNINGS)])
def test_what_takes_nothing_away_is_no_cause(warnings, text):
    found = refused(warnings=warnings)
    best = found.decision.best._replace(model=found.calibrated)
    cause = describe_cause(replace(found, decision=found.decision._replace(best=best)), SAID)
    assert (cause["text"], cause["after"]) == (text, None)


def test_a_verdict_with_a_name_has_none():
    assert explain_example().to_dict()["likely_cause"] is None


def test_a_refusal_on_a_terminal_begins_with_cause_reason_and_what_to_do():
    data = describe(refused()) | {"next_test": {"text": "Weigh it."}}
    lines = [line for line in _shown(data) if isinstance(line, str)]
    assert [line.partition(":")[0] for line in lines[:4]] == [
        "REFUSED",
        "Most likely cause",
        "Not named, because",
        "Do this next",
    ]
    assert "Side force (force 3.1 N)." in lines[1]
    assert lines[3].endswith("Weigh it.")
