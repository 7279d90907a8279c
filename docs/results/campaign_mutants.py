"""How many mutants of the physics were tried, and what became of them."""

from docs.results._campaign import count, try_out
from tests.campaigns import mutants

OPTIONAL = True
RECORD = True
TRIALS = 300


def compute():
    """Counts of outcomes."""
    return count(try_out(mutants, TRIALS))
