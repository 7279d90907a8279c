"""How many random machines were held against the independent simulator, and what became of them."""

from docs.results._campaign import count, try_out
from tests.campaigns import agreement

OPTIONAL = True
RECORD = True
TRIALS = 300


def compute():
    """Counts of outcomes."""
    return count(try_out(agreement, TRIALS))
