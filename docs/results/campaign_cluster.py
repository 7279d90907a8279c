"""How many sweeps on disturbed clusters were tried, and what became of them."""

from docs.results._campaign import count, try_out
from tests.campaigns import cluster

OPTIONAL = True
RECORD = True
TRIALS = 120


def compute():
    """Counts of outcomes."""
    return count(try_out(cluster, TRIALS))
