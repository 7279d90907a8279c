"""How many killed sweeps were tried, and what became of them."""

from docs.results._campaign import count, try_out
from tests.campaigns import kills

OPTIONAL = True
RECORD = True
TRIALS = 1000


def compute():
    """Counts of outcomes."""
    return count(try_out(kills, TRIALS))
