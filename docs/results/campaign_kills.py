"""How many killed sweeps were tried, and what became of them."""

from docs.results._campaign import add_round
from tests.campaigns import kills

OPTIONAL = True
RECORD = True
ROUND = 200


def compute():
    """The record, with a further round."""
    return add_round(kills, ROUND, is_void=is_void)


def is_void(what):
    """Whether a sweep had ended before it was to be killed."""
    return what.endswith(kills.NOT_STRUCK)
