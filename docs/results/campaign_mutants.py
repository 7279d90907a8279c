"""How many mutants of the physics were tried, and what became of them."""

from docs.results import Number
from docs.results._campaign import add_round, as_percentage
from tests.campaigns import mutants

OPTIONAL = True
RECORD = True
ROUND = 50
START = 112
"""Seed of the first mutant: those before found gaps in the tests, which are closed."""


def compute():
    """The record, with a further round: survivors are listed, and the share of those that were caught is told."""
    record = add_round(mutants, ROUND, lambda outcome: outcome.word.endswith(": survives"), start=START)
    survivors = len(record["listed"].rows)
    caught = record["trials"].value - survivors
    return record | {"survivors": Number(survivors), "caught": as_percentage(caught / record["trials"].value)}
