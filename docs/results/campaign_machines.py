"""How many machines at random were run, and what became of them."""

from docs.results._campaign import count, try_out
from tests.campaigns import machines

OPTIONAL = True
RECORD = True
TRIALS = 10000


def compute():
    """Counts of outcomes."""
    return count(try_out(machines, TRIALS))
