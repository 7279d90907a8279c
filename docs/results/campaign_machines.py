"""How many machines at random were run, and what became of them."""

from docs.results import Number
from docs.results._campaign import add_round, as_percentage
from tests.campaigns import machines

OPTIONAL = True
RECORD = True
ROUND = 500
CLOSES = "closes"
KEYS = "engine_near", "valve_near", "engine_wide", "valve_wide"
"""Ends of the names of numbers, for each of the kinds."""


def compute():
    """The record, with a further round, and how many machines had no result, in all and of each kind."""
    record = add_round(machines, ROUND)
    rows = record["outcomes"].rows
    trials, named = (
        {
            kind: sum(int(row[2].value) for row in rows if row[0] == kind and is_counted(row[1]))
            for kind in machines.KINDS
        }
        for is_counted in (lambda what: True, lambda what: what != CLOSES)
    )
    shares = {f"named_{key}": named[kind] / trials[kind] for key, kind in zip(KEYS, machines.KINDS, strict=True)}
    record["named"] = Number(sum(named.values()))
    shares["named_share"] = sum(named.values()) / sum(trials.values())
    return record | {key: as_percentage(share) for key, share in shares.items()}
