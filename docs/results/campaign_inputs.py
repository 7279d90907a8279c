"""How many spoilt inputs were tried, and what became of them."""

from docs.results._campaign import count, try_out
from tests.campaigns import inputs

OPTIONAL = True
RECORD = True
TRIALS = 10000


def compute():
    """Counts of outcomes."""
    return count(try_out(inputs, TRIALS))
