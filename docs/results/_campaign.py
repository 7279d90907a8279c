"""What a campaign found, as tables for the text. A record grows by rounds, each with seeds that no round before had."""

from collections import Counter
from math import floor, log10

from scipy.stats import chi2

from docs.results import Number, Table, describe_code, hash_files, load
from docs.results._kept import find_kept
from tests.campaigns.campaign import run_campaign

JOBS = 2
CONFIDENCE = 0.95
OUTCOMES = ["tried", "what became of it", "trials"]
ROUNDS = ["seeds", "trials", "promises broken", "made on", "by commit"]
LISTED = ["seed", "what became of it", "where"]


def try_out(campaign, trials, first=0):
    """Outcomes of a campaign by seed.

    Parameters
    ----------
    campaign : module
        Of `tests.campaigns`.
    trials : int
    first : int
        Seed of the first trial.
    """
    name = campaign.__name__.rpartition(".")[2]
    code = hash_files("apesim", "valve", "engine", "studies", "tests/campaigns")
    seeds = range(first, first + trials)
    return run_campaign(campaign.__name__, seeds, find_kept("campaign", code) / name, JOBS)


def add_round(campaign, trials, is_listed=lambda outcome: outcome.is_broken, start=0, is_void=lambda what: False):
    """Values of a campaign's record once a further round of trials is added to those that it has.

    Parameters
    ----------
    campaign : module
        Of `tests.campaigns`. The words of its outcomes are "kind: what became of it".
    trials : int
        Trials of the round.
    is_listed : function
        Whether an outcome is told with its detail.
    start : int
        Seed of the first round's first trial; those before were used to find faults, and are no fresh ones. A record
        that begins with another one is begun anew.
    is_void : function
        Whether what became of a trial says that it tried nothing of what is promised: it does not count in the bound.

    Returns
    -------
    dict
        How many trials in all, how many of them count, how many broke a promise, the bound on their share, counts of
        outcomes, rounds, and the outcomes that are listed.
    """
    outcomes, rounds, listed = read_rounds(f"campaign_{campaign.__name__.rpartition('.')[2]}", start)
    before = sum(int(row[1].value) for row in rounds)
    first = start + before
    found = try_out(campaign, trials, first)
    counts = Counter({(kind, what): int(number.value) for kind, what, number in outcomes})
    counts.update(words_of(one) for one in found.values())
    (_, day), (_, commit) = describe_code()
    newly_broken = sum(one.is_broken for one in found.values())
    rounds = [*rounds, [f"{first} to {first + trials - 1}", Number(trials), Number(newly_broken), day, commit]]
    listed = [*listed, *([f"{seed}", one.word, one.detail] for seed, one in found.items() if is_listed(one))]
    broken = sum(int(row[2].value) for row in rounds)
    counted = sum(number for (_, what), number in counts.items() if not is_void(what))
    return {
        "trials": Number(before + trials),
        "counted": Number(counted),
        "broken": Number(broken),
        "bound": as_percentage(bound(broken, counted)),
        "outcomes": Table(OUTCOMES, [[*words, Number(number)] for words, number in sorted(counts.items())]),
        "rounds": Table(ROUNDS, join_rounds(rounds)),
        "listed": Table(LISTED, listed),
    }


def read_rounds(record, start):
    """Rows of a record's outcomes, rounds and listed outcomes; none where no record begins with seed `start` yet."""
    try:
        values = load(record).values
    except FileNotFoundError:
        return [], [], []
    outcomes, rounds, listed = (values[key].rows for key in ("outcomes", "rounds", "listed"))
    begins = int(rounds[0][0].split(" to ")[0])
    return (outcomes, rounds, listed) if begins == start else ([], [], [])


def words_of(outcome):
    """What was tried, and what became of it; a trial that was ended cannot tell what it tried.

    Examples
    --------
    >>> from tests.campaigns.campaign import Outcome
    >>> words_of(Outcome("archive: done")), words_of(Outcome("hangs"))
    (('archive', 'done'), ('any', 'hangs'))
    """
    kind, _, what = outcome.word.partition(": ")
    return (kind, what) if what else ("any", kind)


def join_rounds(rows):
    """Rounds of one day by one commit, whose seeds follow one another, as one.

    Parameters
    ----------
    rows : list of list
        Seeds, trials, promises broken, day and commit, in the order of their seeds.

    Returns
    -------
    list of list

    Examples
    --------
    >>> rows = [["0 to 9", Number(10), Number(0), "2026-11-27", "`1333981`"]]
    >>> [(row[0], row[1].value) for row in join_rounds([*rows, ["10 to 29", Number(20), *rows[0][2:]]])]
    [('0 to 29', 30)]
    """
    joined = []
    for seeds, trials, broken, *made in rows:
        first, last = seeds.split(" to ")
        if joined and joined[-1][3:] == made and int(joined[-1][0].split(" to ")[1]) == int(first) - 1:
            before, more, more_broken, *_ = joined.pop()
            first = before.split(" to ")[0]
            trials, broken = (Number(int(a.value + b.value)) for a, b in ((trials, more), (broken, more_broken)))
        joined.append([f"{first} to {last}", trials, broken, *made])
    return joined


def bound(broken, trials):
    """Upper bound on the share of trials that break a promise, with 95 % confidence: 3/n if none of n did.

    Parameters
    ----------
    broken, trials : int

    Returns
    -------
    float

    Examples
    --------
    >>> f"{bound(0, 1000):.4f} {bound(1, 1000):.4f}"
    '0.0030 0.0047'
    """
    return float(chi2.ppf(CONFIDENCE, 2 * (broken + 1))) / (2.0 * trials)


def as_percentage(share):
    """A share as a number with two digits."""
    value = 100.0 * share
    return Number(value, "%", 0.05 * 10.0 ** floor(log10(value)) if value else 0.0)
