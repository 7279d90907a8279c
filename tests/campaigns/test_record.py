"""Records of campaigns, which grow by rounds, and the tables that the page makes of them."""

import pytest

from docs.results import Number, campaigns
from tests.campaigns import record
from tests.campaigns.campaign import Outcome
from tests.campaigns.record import add_round, bound, find_next_seed, read_record

FIRST = {3: Outcome("bits: seen"), 4: Outcome("bits: unseen", True, "at 3"), 5: Outcome("hangs", True, "longer")}
SECOND = {6: Outcome("bits: seen"), 7: Outcome("bits: seen"), 8: Outcome("bits: not reached", is_void=True)}


@pytest.fixture
def lines(tmp_path, monkeypatch):
    """Lines of a record of two rounds."""
    monkeypatch.setattr(record, "FOLDER", tmp_path)
    assert find_next_seed("bits") == 0
    for outcomes in (FIRST, SECOND):
        add_round("bits", outcomes)
    return read_record("bits")


def test_rounds_are_added_with_seeds_outcomes_and_what_they_count(lines):
    assert [line[2:] for line in lines] == [
        (3, 5, "any", "hangs", 1, 1, 1, "5: longer"),
        (3, 5, "bits", "seen", 1, 1, 0, ""),
        (3, 5, "bits", "unseen", 1, 1, 1, "4: at 3"),
        (6, 8, "bits", "not reached", 1, 0, 0, ""),
        (6, 8, "bits", "seen", 2, 2, 0, ""),
    ]
    assert find_next_seed("bits") == 9


def test_outcomes_are_summed_by_kind_and_rounds_told_one_by_one(lines):
    table = campaigns._tabulate_outcomes(lines)
    assert table.columns[:2] == ["tried", "seen"]
    assert [[row[0], sum(cell.value for cell in row[1:])] for row in table.rows] == [["any", 1], ["bits", 5]]
    rounds = [row[2:] for row in campaigns._tabulate_rounds(lines).rows]
    assert rounds == [["3 to 5", Number(3), Number(2)], ["6 to 8", Number(3), Number(0)]]


def test_no_two_rounds_of_a_record_have_a_seed_in_common_and_each_is_whole():
    for name in (path.stem for path in record.FOLDER.glob("*.csv")):
        end = -1
        for first, last in dict.fromkeys(line[2:4] for line in read_record(name)):
            counts = [line.count for line in read_record(name) if line.first == first]
            assert first > end and sum(counts) == last - first + 1
            end = last


@pytest.mark.parametrize(("broken", "trials", "share"), [(0, 300, 0.00998), (0, 10000, 2.996e-4), (2, 100, 0.0630)])
def test_the_bound_is_that_of_rare_events(broken, trials, share):
    assert bound(broken, trials) == pytest.approx(share, rel=1e-3)


@pytest.mark.parametrize(("share", "text"), [(0.0003, "0.030"), (0.01234, "1.2"), (0.93, "93"), (0.0, "0")])
def test_a_share_has_two_digits(share, text):
    assert campaigns.as_percentage(share).digits == text
