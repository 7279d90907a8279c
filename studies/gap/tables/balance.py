"""Balance in which a gap lives: one smooth unknown force, heat, leak, area or delay at a time, without a name.

The nodes of a table have a Gaussian prior: neighbours are alike, and their size is that under which the data are most
probable. So a table takes as much of the gap as stands out of noise, and pays for what it moves.
"""

from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import Fitted, descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.estimation.residuals import WhitenedResiduals, first_steps
from apesim.studies.gap.search.candidates import Candidate, strength

REACH = 2.0
"""Nodes over which what one says of its neighbours fades to 1/e."""
TRENDS = 0.5, 0.9, 0.99
"""Shares of a node's variance that it may have in common with all of its branch, at the ends; the data choose."""
SIZES = np.logspace(-3.0, 0.5, 29)
"""Standard deviations of the nodes, over their range, among which the data choose."""
ROUNDS = 2
"""Rounds of choosing sizes and fitting the nodes with them."""
ALIKE = 1.5
"""Times by which a size may be another without a fit of its own."""
SWEEPS = 3
"""Sweeps of choosing the sizes of one branch after the other."""


class Balance(NamedTuple):
    """What a table of one unknown quantity takes of a gap, and what it costs."""

    name: str
    """Name of the effect."""
    balance: str
    """force, heat, leak, area or delay"""
    fall: float
    """Fall of the sum of squares, priors included."""
    price: float
    """Twice the logarithm of Occam's factor: what the nodes pay that the data move."""
    nodes: float
    """Number of nodes that the data move: the trace of ``(1 + K)^-1 K``, with K as in `most_probable`."""
    residuals: object
    """`Smoothed`"""
    fitted: Fitted
    """Values of the nodes, or those that a fit is to start from."""
    model: object = None
    """`apesim.studies.estimation.model.Model`, fitted through the simulator; None: it is not yet."""

    @property
    def gain(self) -> float:
        """Twice the logarithm of how much more probable the data are with the table: ``fall - price``."""
        return self.fall - self.price


class Smoothed(WhitenedResiduals):
    """A residuals whose last parameters are the nodes of a table.

    Parameters
    ----------
    machine, runs, parameters, noise
        See `WhitenedResiduals`.
    root : (q, q) float array
        Of the nodes' prior covariance, lower triangle.
    """

    def __init__(self, machine, runs, parameters, noise, root, *, starts=None):
        super().__init__(machine, runs, parameters, noise, starts=starts)
        self.root = root

    def pulls(self, x):
        """Return what `WhitenedResiduals.pulls` does, with that of the nodes' prior."""
        pulls, nodes = super().pulls(x), len(self.root)
        pulls[-nodes:] = np.linalg.solve(self.root, np.asarray(x)[-nodes:])
        return pulls

    def smoothed(self, root):
        """Return these residuals with another prior of the nodes."""
        other = Smoothed(self.machine, self.runs, self.parameters, self.noise, root, starts=self.starts)
        other.counter.add(self.simulations)
        return other


def balances(base, effects, work):
    """What each table takes of the gap if all is straight, the most probable first.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    effects : sequence of apesim.effect.Effect
        The library; what is not tabulated, or on already, is left out.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    list of Balance
    """
    own = base.residuals.machine.effects
    tables = [effect for effect in effects if effect.tabulated and not effect.is_on(getattr(own, effect.name))]
    found = work.each("weighing balances", straight, [(base, effect) for effect in tables])
    work.simulations.add(sum(balance.residuals.simulations for balance in found))
    return sorted(found, key=lambda balance: -balance.gain)


def straight(base, effect):
    """What a table takes by its sensitivities at the calibrated machine.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
    effect : apesim.effect.Effect

    Returns
    -------
    Balance
    """
    nodes, old = [strength(effect, name) for name in effect.strengths], len(base.fitted.x)
    known = base.residuals
    parameters, root = [*known.parameters, *nodes], np.eye(len(nodes))
    residuals = Smoothed(known.machine, known.runs, parameters, known.noise, root, starts=known.starts)
    x = np.append(base.fitted.x, np.zeros(len(nodes)))
    errors = residuals.at(x)
    steps = np.append(base.fitted.steps, first_steps(len(nodes)))
    columns, steps = residuals.jacobian(x, errors, steps, range(old, len(x)))
    jacobian = np.column_stack([np.vstack([base.fitted.jacobian, np.zeros((len(nodes), old))]), columns])
    fitted = Fitted(x, errors, jacobian, False, steps)
    return weighed(Balance(effect.name, effect.tabulated, 0.0, 0.0, 0.0, residuals, fitted))


def through_the_simulator(base, balance):
    """Fit a balance together with the nuisances, the sizes of the nodes chosen anew where the first fit leads to.

    Raises
    ------
    EndedEarly
        The simulation fails where the straight model leads.
    """
    for number in range(ROUNDS):
        before, balance = balance, weighed(balance)
        if number and not resized(before.residuals.root, balance.residuals.root):
            balance = before
            break
        residuals = balance.residuals
        fitted = descend(residuals, balance.fitted.x, balance.fitted.jacobian, balance.fitted.steps)
        balance = balance._replace(fall=base.cost - fitted.cost, fitted=fitted)
        if not fitted.converged:
            break
    nodes = tuple(residuals.parameters[-len(residuals.root) :])
    return balance._replace(model=Model((*base.candidates, Candidate(balance.name, nodes, ())), residuals, fitted))


def resized(root, other):
    """Whether a node's size is another by more than `ALIKE`."""
    ratios = np.diag(root) / np.diag(other)
    return bool(np.any(np.maximum(ratios, 1.0 / ratios) > ALIKE))


def weighed(balance):
    """Return a balance with the most probable sizes of its nodes, and the nodes to which they lead."""
    residuals, (x, errors, jacobian, _, steps) = balance.residuals, balance.fitted
    nodes = len(residuals.root)
    old = len(x) - nodes
    columns = jacobian[:-nodes, old:]
    bare = find_nuisance_space(jacobian[:-nodes, :old]).project_out(columns)
    branches = [parameter.key.rsplit("_at_", 1)[0] for parameter in residuals.parameters[old:]]
    left, found = errors[:-nodes] - columns @ x[old:], []
    for trend in TRENDS:
        root = np.linalg.cholesky(likeness(branches, trend))
        sizes, *outcome = most_probable(bare @ root, left, branches)
        found.append((sizes[:, None] * root, *outcome))
    root, fall, price, moved, shift = max(found, key=lambda one: one[1] - one[2])
    jacobian = np.vstack([jacobian[:-nodes], np.hstack([np.zeros((nodes, old)), np.linalg.inv(root)])])
    x = np.append(x[:old], root @ shift)
    fitted = Fitted(x, errors, jacobian, False, steps)
    return Balance(balance.name, balance.balance, fall, price, moved, residuals.smoothed(root), fitted)


def most_probable(columns, errors, branches):
    """The sizes of the nodes, one for each branch, under which residuals are most probable, and what they take then.

    With the columns A of the nodes, the residuals e and the sizes s, ``K = s A'A s`` and ``b = -s A'e``. The nodes then
    are ``x = (1 + K)^-1 b``, and the sizes are chosen for the largest ``fall - price``::

        fall = x'b,    price = ln det(1 + K),    moved = trace((1 + K)^-1 K)

    It is the evidence of a linear model with a Gaussian prior: the price is MacKay's Occam factor, ``moved`` his number
    of well determined parameters [1]_.

    Parameters
    ----------
    columns : (n, q) float array
        Sensitivities to nodes of the size 1, independent of each other.
    errors : (n,) float array
        Residuals [standard deviations].
    branches : sequence of str
        Name of the branch of each node.

    Returns
    -------
    sizes : (q,) float array
    fall, price, moved : float
        See `Balance`.
    x : (q,) float array
        The most probable nodes, over their sizes.

    References
    ----------
    .. [1] D. J. C. MacKay, "Bayesian interpolation", Neural Comput. 4, 1992, pp. 415-447,
       doi 10.1162/neco.1992.4.3.415.
    """
    normal, seen, of = columns.T @ columns, -columns.T @ errors, np.array(branches)

    def outcome(sizes):
        own = sizes[:, None] * normal * sizes
        x = np.linalg.solve(np.eye(len(sizes)) + own, sizes * seen)
        price = np.linalg.slogdet(np.eye(len(sizes)) + own)[1]
        moved = np.trace(np.linalg.solve(np.eye(len(sizes)) + own, own))
        return float(x @ (sizes * seen)), float(price), float(moved), x

    def tried(sizes, branch):
        return [np.where(of == branch, size, sizes) for size in SIZES]

    def gain(sizes):
        fall, price, *_ = outcome(sizes)
        return fall - price

    sizes = max((np.full(len(of), size) for size in SIZES), key=gain)
    for _ in range(SWEEPS):
        for branch in dict.fromkeys(branches):
            sizes = max(tried(sizes, branch), key=gain)
    return sizes, *outcome(sizes)


def likeness(branches, share):
    """Correlation of nodes before anything is measured, (q, q).

    Those of one branch have a share of their variance in common, a constant and a slope, so that a trend goes on where
    nothing was measured; what differs from it fades with their distance.
    """
    of, rank = np.array(branches), np.arange(len(branches))
    along = np.concatenate([np.linspace(-1.0, 1.0, branches.count(name)) for name in dict.fromkeys(branches)])
    same = of[:, None] == of[None, :]
    trend = 0.5 * (1.0 + along[:, None] * along[None, :])
    wild = np.exp(-np.abs(rank[:, None] - rank[None, :]) / REACH)
    return same * (share * trend + (1.0 - share) * wild)
