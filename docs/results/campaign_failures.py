"""How many calls of the system were made to fail, and what became of it."""

from docs.results._campaign import add_round
from tests.campaigns import failures

OPTIONAL = True
RECORD = True
ROUND = len(failures.TRIALS)


def compute():
    """The record, with a further round."""
    return add_round(failures, ROUND, is_void=is_void)


def is_void(what):
    """Whether the call that was to fail never came."""
    return what == failures.UNREACHED
