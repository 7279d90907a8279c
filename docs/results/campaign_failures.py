"""How many calls of the system were made to fail, and what became of it."""

from docs.results._campaign import count, try_out
from tests.campaigns import failures

OPTIONAL = True
RECORD = True
TRIALS = 2000


def compute():
    """Counts of outcomes."""
    return count(try_out(failures, TRIALS))
