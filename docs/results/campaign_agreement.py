"""How many random machines were held against the independent simulator, and what became of them."""

from docs.results._campaign import add_round
from tests.campaigns import agreement

OPTIONAL = True
RECORD = True
ROUND = 300
START = 300
"""Seed of the first machine: those before found a fault of the independent simulator."""


def compute():
    """The record, with a further round."""
    return add_round(agreement, ROUND, start=START)
