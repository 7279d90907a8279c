"""What is not in the library: the table that closes the gap best, verified like any effect, without a name."""

from contextlib import suppress
from math import log
from typing import NamedTuple

from studies.gap.balance import through_the_simulator
from studies.gap.heldout import held_out, left_over
from studies.gap.problem import EndedEarly
from studies.gap.select import priced, term
from studies.gap.suggest import suggestion
from studies.measured import CHECK, GATE

FITTED = 4
"""Tables that are fitted through the simulator, the best by a straight model."""
WEIGHED = 2
"""Tables that are held against a name."""
MARGIN = 2.0 * log(10.0)
"""Penalised cost by which a table has to beat a name to refuse it: the data are ten times as probable."""


class Tabulated(NamedTuple):
    """A table that is added in place of a law."""

    balance: object
    """`studies.gap.balance.Balance`, fitted"""
    judged: object
    """`studies.gap.heldout.HeldOut` on the check runs, without any on the gate runs; None: there are neither."""
    suggestion: str
    """Form in physical variables; "" where none is found."""

    @property
    def model(self):
        """`studies.gap.refit.Model`"""
        return self.balance.model


def tabulate(base, ranked, measured, noise, report=None):
    """Fit the likeliest tables, and judge the best of them by runs that it was not fitted to.

    Parameters
    ----------
    base : studies.gap.refit.Model
        The calibrated machine.
    ranked : list of Balance
        See `studies.gap.balance.balances`.
    measured : studies.measured.Measured
    noise : dict
        See `studies.gap.noise_source.noise_of`.
    report : callable, optional
        Told how many are done, and of how many.

    Returns
    -------
    Tabulated or None
        None: no table makes the data more probable.
    """
    found = []
    for done, balance in enumerate(ranked[:FITTED], 1):
        with suppress(EndedEarly):
            found.append(through_the_simulator(base, balance))
        if report:
            report(done, min(FITTED, len(ranked)))
    found = [balance for balance in found if balance.gain > 0.0]
    if not found:
        return None
    checks, gates = measured.of(CHECK), measured.of(GATE)

    def worth(balance):
        return balance.gain - (left_over(balance.model, gates, noise).misfit if gates and checks else 0.0)

    best, runs = max(found, key=worth), checks or gates
    judged = held_out(base, best.model, runs, noise) if runs else None
    return Tabulated(best, judged, suggestion(best.model))


def likelier(base, model, ranked, library):
    """The table, without a name, that makes the data more probable than an explanation that has one.

    A table is one unknown effect, and pays as much for being there as a name does.

    Parameters
    ----------
    base, model : studies.gap.refit.Model
        The calibrated machine, without and with the explanation.
    ranked : list of Balance
        See `studies.gap.balance.balances`.
    library : int
        Number of candidates.

    Returns
    -------
    Balance or None
    """
    enough = base.cost - priced(model, library).cost + term(library) + MARGIN
    for balance in ranked[:WEIGHED]:
        with suppress(EndedEarly):
            if balance.gain > enough and through_the_simulator(base, balance).gain > enough:
                return balance
    return None
