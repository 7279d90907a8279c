from apesim.archive.completeness import missing_runs
from tests.archive_samples import sample


def test_missing_runs_are_given_as_gaps():
    assert missing_runs(sample([0, 1, 2])) == []
    assert missing_runs(sample([2, 3, 6])) == [(0, 1), (4, 5)]
    assert missing_runs(sample([2, 3, 6]), total=10) == [(0, 1), (4, 5), (7, 9)]
    assert missing_runs(sample([0], runs_planned="3")) == [(1, 2)]
    assert missing_runs(sample([]), total=2) == [(0, 1)]
    assert missing_runs(sample([]), total=0) == missing_runs(sample([])) == []
    assert missing_runs(sample([1, 5]), total=3) == [(0, 0), (2, 2)]
    assert missing_runs(sample([2**62])) == [(0, 2**62 - 1)]
