"""Records of campaigns, which grow by rounds."""

from types import SimpleNamespace

import pytest

from docs import results
from docs.results import Number, Result, _campaign
from docs.results._campaign import add_round, as_percentage, bound
from tests.campaigns import archives
from tests.campaigns.campaign import Outcome

FIRST, SECOND = 20, 14
RECORD = "campaign_archives"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Records and outcomes are kept apart from those of the project."""
    monkeypatch.setattr(results, "HERE", tmp_path)
    monkeypatch.setattr(_campaign, "find_kept", lambda name, code: tmp_path / name)
    return tmp_path


def keep(values, name=RECORD):
    results.save(Result(name, "", "", 0.0, "", {}, "", "", values))


def counts_of(values):
    return {tuple(words): number.value for *words, number in values["outcomes"].rows}


def test_a_second_round_has_seeds_of_its_own_and_is_added_to_the_first(folder):
    keep(add_round(archives, FIRST))
    record = add_round(archives, SECOND)
    (folder / "campaign" / "archives" / "archives.jsonl").unlink()
    whole = _campaign.try_out(archives, FIRST + SECOND)
    words = [tuple(one.word.split(": ", 1)) for one in whole.values()]
    assert counts_of(record) == {word: words.count(word) for word in words}
    assert record["trials"] == Number(FIRST + SECOND)
    assert [row[:3] for row in record["rounds"].rows] == [["0 to 33", Number(34), Number(0)]]


def test_what_is_broken_is_listed_with_its_seed_and_raises_the_bound(monkeypatch):
    def run_campaign(name, seeds, out, jobs):
        return {seed: Outcome("bits: broken" if seed == 7 else "bits: seen", seed == 7, "at 3") for seed in seeds}

    monkeypatch.setattr(_campaign, "run_campaign", run_campaign)
    campaign = SimpleNamespace(__name__="tests.campaigns.bits")
    record = add_round(campaign, 1000)
    assert record["listed"].rows == [["7", "bits: broken", "at 3"]]
    assert (record["broken"], record["bound"].text) == (Number(1), "0.47\u202f%")
    keep(record, "campaign_bits")
    record = add_round(campaign, 1000)
    assert (record["broken"], record["bound"].text, len(record["listed"].rows)) == (Number(1), "0.24\u202f%", 1)


def test_trials_that_tried_nothing_are_not_counted(monkeypatch):
    def run_campaign(name, seeds, out, jobs):
        return {seed: Outcome(f"bits: {'never changed' if seed % 4 == 0 else 'seen'}") for seed in seeds}

    monkeypatch.setattr(_campaign, "run_campaign", run_campaign)
    campaign = SimpleNamespace(__name__="tests.campaigns.bits")
    for _ in range(2):
        record = add_round(campaign, 200, is_void=lambda what: what == "never changed")
        keep(record, "campaign_bits")
    assert (record["trials"], record["counted"], record["bound"].text) == (Number(400), Number(300), "1.00\u202f%")


def test_a_trial_that_was_ended_is_counted_without_what_it_tried(monkeypatch):
    monkeypatch.setattr(
        _campaign, "run_campaign", lambda name, seeds, out, jobs: {s: Outcome("hangs", True, "longer") for s in seeds}
    )
    record = add_round(SimpleNamespace(__name__="tests.campaigns.bits"), 3)
    assert counts_of(record) == {("any", "hangs"): 3}
    assert record["broken"] == Number(3)


@pytest.fixture
def campaign(monkeypatch):
    """One in which nothing is broken."""
    monkeypatch.setattr(
        _campaign, "run_campaign", lambda name, seeds, out, jobs: {s: Outcome("bits: seen") for s in seeds}
    )
    return SimpleNamespace(__name__="tests.campaigns.bits")


def test_rounds_begin_behind_the_seeds_that_faults_were_found_by(campaign):
    keep(add_round(campaign, 100, start=3000), "campaign_bits")
    record = add_round(campaign, 200, start=3000)
    assert [row[0] for row in record["rounds"].rows] == ["3000 to 3299"]
    assert (record["trials"], record["bound"].text) == (Number(300), "1.00\u202f%")


def test_a_record_that_begins_with_another_seed_is_begun_anew(campaign):
    keep(add_round(campaign, 100, start=3000), "campaign_bits")
    record = add_round(campaign, 300, start=4000)
    assert [row[0] for row in record["rounds"].rows] == ["4000 to 4299"]
    assert (record["trials"], counts_of(record)) == (Number(300), {("bits", "seen"): 300})


def test_rounds_of_another_commit_or_day_or_with_seeds_between_stand_apart():
    def row(first, last, broken, day, commit):
        return [f"{first} to {last}", Number(last - first + 1), Number(broken), day, commit]

    rows = [
        row(0, 9, 1, "monday", "a"),
        row(10, 19, 2, "monday", "a"),
        row(20, 29, 0, "monday", "b"),
        row(30, 39, 0, "tuesday", "b"),
        row(50, 59, 0, "tuesday", "b"),
    ]
    assert _campaign.join_rounds(rows) == [row(0, 19, 3, "monday", "a"), *rows[2:]]


@pytest.mark.parametrize(("broken", "trials", "share"), [(0, 300, 0.00998), (0, 10000, 2.996e-4), (2, 100, 0.0630)])
def test_the_bound_is_that_of_rare_events(broken, trials, share):
    assert bound(broken, trials) == pytest.approx(share, rel=1e-3)


@pytest.mark.parametrize(("share", "text"), [(0.0003, "0.030"), (0.01234, "1.2"), (0.93, "93"), (0.0, "0")])
def test_a_share_has_two_digits(share, text):
    assert as_percentage(share).digits == text
