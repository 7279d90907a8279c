"""What is not in the library: the table that closes the gap best, verified like any effect, without a name."""

from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.residuals import unless_ended
from apesim.studies.gap.decide.held_out import HeldOut, all_left_over, held_out, leave_one_out
from apesim.studies.gap.search.model_selection import priced, term
from apesim.studies.gap.tables.balance import Balance, through_the_simulator
from apesim.studies.gap.tables.suggest import suggestion
from apesim.studies.gap.thresholds import TABLE_MARGIN
from apesim.studies.measured import CHECK, GATE

FITTED = 4
"""Tables that are fitted through the simulator, the best by a straight model."""
WEIGHED = 2
"""Tables that are held against a name."""


class Tabulated(NamedTuple):
    """A table that is added in place of a law."""

    balance: Balance
    """What the table takes of the gap, fitted."""
    judged: HeldOut | None
    """How large the gap is on the check runs, without any on the gate runs, without either with
    operating points left out one at a time; None: there is one alone."""
    suggestion: str
    """Form in physical variables; "" where none is found."""

    @property
    def model(self):
        """Fitted machine that the tables are added to."""
        return self.balance.model


class Tables:
    """All tables, each fitted through the simulator when it is first asked for.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    ranked : list of Balance
        See `apesim.studies.gap.tables.balance.balances`.
    work : apesim.studies.gap.work.Work
    """

    def __init__(self, base, ranked, work):
        self.base, self.ranked, self.work = base, ranked, work
        self._known = {}

    def fitted(self, most, least=0.0):
        """Tables fitted through the simulator.

        Parameters
        ----------
        most : int
            So many, the best by a straight model.
        least : float
            Of these, those that promise more gain than this.

        Returns
        -------
        list of Balance
            Without those that gain less when fitted, or end early.
        """
        wanted = [balance for balance in self.ranked[:most] if balance.gain > least]
        new = [balance for balance in wanted if balance.name not in self._known]
        tasks = [(through_the_simulator, self.base, balance) for balance in new]
        found = self.work.each("fitting tables", unless_ended, tasks)
        for before, balance in zip(new, found, strict=True):
            self._known[before.name] = balance
            if balance:
                self.work.simulations.add(balance.residuals.simulations - before.residuals.simulations)
        known = [self._known[balance.name] for balance in wanted]
        return [balance for balance in known if balance and balance.gain > least]


def tabulate(tables, measured, noise):
    """Fit the likeliest tables, and judge the best of them by runs that it was not fitted to.

    Parameters
    ----------
    tables : Tables
    measured : apesim.studies.measured.Measured
    noise : dict
        See `apesim.studies.estimation.noise.estimation.noise_of`.

    Returns
    -------
    Tabulated or None
        None: no table makes the data more probable.
    """
    found = tables.fitted(FITTED)
    if not found:
        return None
    base, work = tables.base, tables.work
    checks, gates = measured.of(CHECK), measured.of(GATE)
    worth = [balance.gain for balance in found]
    if gates and checks:
        left = all_left_over(base, [balance.model for balance in found], gates, noise, work)
        worth = [gain - own.misfit for gain, own in zip(worth, left, strict=True)]
    best, runs = found[int(np.argmax(worth))], checks or gates
    if runs:
        judged = held_out(base, best.model, runs, noise, work)
    else:
        judged = leave_one_out(base, best.model, work)
    return Tabulated(best, judged, suggestion(best.model))


def likelier(tables, model, library):
    """The table, without a name, that makes the data more probable than an explanation that has one.

    A table is one unknown effect, and pays as much for being there as a name does.

    Parameters
    ----------
    tables : Tables
    model : apesim.studies.estimation.model.Model
        The explanation.
    library : int
        Number of candidates.

    Returns
    -------
    Balance or None
    """
    enough = tables.base.cost - priced(model, library).cost + term(library) + TABLE_MARGIN
    return next(iter(tables.fitted(WEIGHED, enough)), None)
