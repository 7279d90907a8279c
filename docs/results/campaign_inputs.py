"""How many spoilt inputs were tried, and what became of them."""

from docs.results._campaign import add_round
from tests.campaigns import inputs

OPTIONAL = True
RECORD = True
ROUND = 10000
START = 40_000
"""Seed of the first input: those before were used to find faults, of apesim or of what is asked of a refusal."""


def compute():
    """The record, with a further round."""
    return add_round(inputs, ROUND, start=START)
