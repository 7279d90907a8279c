"""How many machines at random were run, and what became of them."""

from docs.results import Number, Table, Value
from docs.results._campaign import add_round, as_percentage
from tests.campaigns import machines

OPTIONAL = True
RECORD = True
ROUND = 500
START = 82_000
"""Seed of the first machine: those before were used to find faults."""
CLOSES = "closes"
KEYS = "engine_near", "valve_near", "engine_wide", "valve_wide"
"""Ends of the names of numbers, for each of the kinds."""


def compute() -> dict[str, Value]:
    """The record, with a further round."""
    return add_shares(add_round(machines, ROUND, start=START))


def add_shares(record: dict[str, Value]) -> dict[str, Value]:
    """Add how many machines have no result and say so, in all and of each kind.

    Parameters
    ----------
    record : dict
        Record of the campaign; what broke a promise is listed, and has no part in the shares.
    """
    outcomes, listed = record["outcomes"], record["listed"]
    assert isinstance(outcomes, Table) and isinstance(listed, Table)
    broken = {str(row[1]) for row in listed.rows}
    trials, named = dict.fromkeys(machines.KINDS, 0), dict.fromkeys(machines.KINDS, 0)
    for kind, what, number in outcomes.rows:
        assert isinstance(number, Number)
        trials[kind] += int(number.value)
        if what != CLOSES and f"{kind}: {what}" not in broken:
            named[kind] += int(number.value)
    shares = {f"named_{key}": named[kind] / trials[kind] for key, kind in zip(KEYS, machines.KINDS, strict=True)}
    shares["named_share"] = sum(named.values()) / sum(trials.values())
    return record | {"named": Number(sum(named.values()))} | {k: as_percentage(share) for k, share in shares.items()}
