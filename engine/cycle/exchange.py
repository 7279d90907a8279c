"""Flows of the gas exchange: the list that their sides, areas, regimes, events and columns of the ledger follow."""

from typing import Generic, NamedTuple, TypeVar

Each = TypeVar("Each")


class Exchange(NamedTuple, Generic[Each]):
    """One thing for each flow of the gas exchange: its sides, its area, its flow, or its column of the ledger."""

    groove: Each
    """Through the groove, from the air before it into the cylinder."""
    exhaust: Each
    """Through the exhaust valve, from the cylinder to the surroundings."""
    feed: Each
    """Through the feed, from the supply into the receiver; shut where the receiver is infinite."""
    pipe: Each
    """Out of the receiver into the intake pipe, or where there is none, to the groove."""


FLOWS = len(Exchange._fields)
"""Number of the flows of the gas exchange."""
GROOVE, EXHAUST, FEED, PIPE = range(FLOWS)
"""Numbers of the flows, in the order of `Exchange`."""
