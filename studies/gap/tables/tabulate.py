"""What is not in the library: the table that closes the gap best, verified like any effect, without a name."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.estimation.residuals import unless_ended
from apesim.studies.gap.decide.held_out import HeldOut, find_all_held_out_residuals, judge_by_runs, leave_one_out
from apesim.studies.gap.search.model_selection import find_penalty, find_term_penalty
from apesim.studies.gap.stage_work import Work
from apesim.studies.gap.tables.balance import Balance, fit_table
from apesim.studies.gap.tables.suggest import suggest_form
from apesim.studies.gap.thresholds import TABLE_MARGIN
from apesim.studies.measured import CHECK, GATE, Measured

MAX_FITTED = 4
"""Tables that are fitted through the simulator, the best by a linear model: what is most probable there has to be among
them."""
MAX_COMPARED = 2
"""Tables that are compared with a name: the best two by a linear model."""


class Tabulated(NamedTuple):
    """A table that is added in place of a law."""

    balance: Balance
    """Table with the part of the gap that it takes, fitted."""
    judged: HeldOut | None
    """How large the gap is on the check runs, without any on the gate runs, without either with
    operating points left out one at a time; None: there is one alone."""
    suggestion: str
    """Form in physical variables; "" where none is found."""

    @property
    def model(self) -> Model:
        """Fitted machine with the table."""
        assert self.balance.model is not None
        return self.balance.model


class Tables:
    """All tables, each fitted through the simulator when it is first asked for.

    `base` is the calibrated machine, `ranked` what `apesim.studies.gap.tables.balance.weigh_balances` gives.
    """

    def __init__(self, base: Model, ranked: Sequence[Balance], work: Work) -> None:
        self.base, self.ranked, self.work = base, ranked, work
        self._fitted: dict[str, Balance | None] = {}

    def fit(self, max_tables: int, min_gain: float = 0.0) -> list[Balance]:
        """Fit the best tables through the simulator, `max_tables` of them by a linear model.

        Those that gain less than `min_gain` when fitted, or whose simulation ends early, are left out.
        """
        wanted = [balance for balance in self.ranked[:max_tables] if balance.gain > min_gain]
        new = [balance for balance in wanted if balance.name not in self._fitted]
        tasks = [(fit_table, self.base, balance, min_gain) for balance in new]
        fits = self.work.each("fitting tables", unless_ended, tasks)
        for before, balance in zip(new, fits, strict=True):
            self._fitted[before.name] = balance
            if balance:
                self.work.simulations.add(balance.residuals.simulations - before.residuals.simulations)
        fitted = [self._fitted[balance.name] for balance in wanted]
        return [balance for balance in fitted if balance and balance.gain > min_gain]


def tabulate(tables: Tables, measured: Measured, noise: dict[str, Any]) -> Tabulated | None:
    """Fit the likeliest tables, and judge the best of them by runs that it was not fitted to.

    None: no table makes the data more probable. `noise` is that of
    `apesim.studies.estimation.noise.estimation.noise_of`.
    """
    fits = tables.fit(MAX_FITTED)
    if not fits:
        return None
    base, work = tables.base, tables.work
    checks, gates = measured.of(CHECK), measured.of(GATE)
    worth = [balance.gain for balance in fits]
    if gates and checks:
        models = [balance.model for balance in fits if balance.model]
        judged_by_gates = find_all_held_out_residuals(base, models, gates, noise, work)
        worth = [gain - residuals.misfit for gain, residuals in zip(worth, judged_by_gates, strict=True)]
    best, runs = fits[int(np.argmax(worth))], checks or gates
    assert best.model is not None
    if runs:
        judged: HeldOut | None = judge_by_runs(base, best.model, runs, noise, work)
    else:
        judged = leave_one_out(base, best.model, work)
    return Tabulated(best, judged, suggest_form(best.model))


def find_likelier_table(tables: Tables, model: Model, library: int) -> Balance | None:
    """Find a table, without a name, that makes the data more probable than an explanation that has one.

    A table is one unknown effect, and pays as much for being there as a name does, among `library` candidates. None:
    the explanation, `model`, is as probable.
    """
    gain = tables.base.fitted.cost - model.fitted.cost - find_penalty(model, library)
    min_gain = gain + find_term_penalty(library) + TABLE_MARGIN
    return next(iter(tables.fit(MAX_COMPARED, min_gain)), None)
