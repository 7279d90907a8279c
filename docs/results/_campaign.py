"""What a campaign found, as tables for the text."""

from collections import Counter

from docs.results import Number, Table, describe_code, hash_files
from docs.results._kept import find_kept
from tests.campaigns.campaign import run_campaign

JOBS = 2


def try_out(campaign, trials):
    """Outcomes of a campaign by seed.

    Parameters
    ----------
    campaign : module
        Of `tests.campaigns`.
    trials : int
    """
    name = campaign.__name__.rpartition(".")[2]
    code = hash_files("apesim", "valve", "engine", "studies", "tests/campaigns")
    return run_campaign(campaign.__name__, range(trials), find_kept("campaign", code) / name, JOBS)


def count(found):
    """Values of a campaign: how many trials, how many broke a promise, outcomes by their words, and when it was made.

    A word is "kind: outcome".
    """
    counts = Counter(one.word for one in found.values())
    rows = [[*word.split(": ", 1), Number(number)] for word, number in sorted(counts.items())]
    broken = sum(one.is_broken for one in found.values())
    return {
        "trials": Number(len(found)),
        "broken": Number(broken),
        "outcomes": Table(["tried", "what became of it", "trials"], rows),
        "made": Table(["what", "value"], describe_code()),
    }
