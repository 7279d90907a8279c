"""Balance in which a gap lives: one smooth unknown force, heat, leak, area or delay at a time, without a name.

The nodes of a table have a Gaussian prior: neighbours are alike, and their size is that under which the data are most
probable. So a table takes as much of the gap as stands out of noise, and pays for what it moves.
"""

from collections.abc import Iterable, Sequence
from enum import StrEnum
from typing import Any, NamedTuple

import numpy as np

from apesim.effect import Effect
from apesim.engine.machine import Machine
from apesim.studies.estimation.engine_starts import Starts
from apesim.studies.estimation.levenberg_marquardt import ROUGH, Fitted, descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.estimation.parameters import Parameter
from apesim.studies.estimation.residuals import WhitenedResiduals, first_steps
from apesim.studies.estimation.scatter import Scatter
from apesim.studies.gap.search.candidates import Candidate, make_strength
from apesim.studies.gap.stage_work import Work
from apesim.studies.measured import MeasuredRun

CORRELATION_LENGTH = 2.0
"""Nodes over which the correlation of neighbours fades to 1/e."""
TRENDS = 0.5, 0.9, 0.99
"""Shares of a node's variance that it may have in common with all of its branch, at the ends; the data choose."""
SIZES = np.logspace(-3.0, 0.5, 29)
"""Standard deviations of the nodes, over their range, among which the data choose."""
MAX_ROUNDS = 2
"""Rounds of choosing sizes and fitting the nodes with them."""
MAX_SIZE_RATIO = 1.5
"""Times by which a size may be another without a fit of its own."""
SWEEPS = 3
"""Sweeps of choosing the sizes of one branch after the other."""


class BalanceKind(StrEnum):
    """The balance in which a table acts."""

    FORCE = "force"
    HEAT = "heat"
    LEAK = "leak"
    AREA = "area"
    DELAY = "delay"


class Balance(NamedTuple):
    """What a table of one unknown quantity takes of a gap, and what it costs."""

    name: str
    """Name of the effect."""
    balance: BalanceKind
    """Balance in which the table acts."""
    fall: float
    """Fall of the sum of squares, priors included."""
    price: float
    """Twice the logarithm of Occam's factor: what the nodes pay that the data move."""
    nodes: float
    """Number of nodes that the data move: the trace of ``(1 + K)^-1 K``, with K as in `find_most_probable`."""
    residuals: "TableResiduals"
    """Residuals as a function of the nuisances and of the nodes."""
    fitted: Fitted
    """Values of the nodes, or those that a fit is to start from."""
    model: Model | None = None
    """Model fitted through the simulator; None: it is not fitted yet."""

    @property
    def gain(self) -> float:
        """Twice the logarithm of how much more probable the data are with the table: ``fall - price``."""
        return self.fall - self.price


class TableResiduals(WhitenedResiduals):
    """Residuals whose last parameters are the nodes of a table, which have a prior together.

    `root` (q, q) is Cholesky's root of the nodes' prior covariance, lower triangle; `noise` is that of
    `apesim.studies.estimation.noise.estimation.noise_of`.
    """

    def __init__(
        self,
        machine: Machine,
        runs: Iterable[MeasuredRun],
        parameters: Sequence[Parameter],
        noise: dict[str, Any] | None,
        root: np.ndarray,
        *,
        starts: Starts | None = None,
        scatter: Scatter | None = None,
    ) -> None:
        super().__init__(machine, runs, parameters, noise, starts=starts, scatter=scatter)
        self.root = root

    def pulls(self, x: np.ndarray) -> np.ndarray:
        """Pulls of the priors at `x` (p,), (p,) [standard deviations], those of the nodes being ``root^-1 x``."""
        pulls, nodes = super().pulls(x), len(self.root)
        pulls[-nodes:] = np.linalg.solve(self.root, np.asarray(x)[-nodes:])
        return pulls

    def with_root(self, root: np.ndarray) -> "TableResiduals":
        """These residuals with another prior of the nodes.

        `root` (q, q) is Cholesky's root of their prior covariance, lower triangle.
        """
        other = self._derived(self.runs, self.noise, self.starts, None, self.scatter)
        other.root = root
        other.counter.add(self.simulations)
        return other


def weigh_balances(base: Model, effects: Iterable[Effect], work: Work) -> list[Balance]:
    """Weigh the tables by what each takes of the gap in a linear model, the most probable first.

    `base` is the calibrated machine; of the library `effects`, what is not tabulated, or on already, is left out.
    """
    known = base.residuals.machine.effects
    tables = [effect for effect in effects if effect.tabulated and not effect.is_on(getattr(known, effect.name))]
    balances = work.each("weighing balances", linearise_table, [(base, effect) for effect in tables])
    work.simulations.add(sum(balance.residuals.simulations for balance in balances))
    return sorted(balances, key=lambda balance: -balance.gain)


def linearise_table(base: Model, effect: Effect) -> Balance:
    """Find what a table takes of the gap, by its sensitivities at the calibrated machine `base`."""
    nodes, old = [make_strength(effect, name) for name in effect.strengths], len(base.fitted.x)
    known = base.residuals
    parameters, root = [*known.parameters, *nodes], np.eye(len(nodes))
    residuals = TableResiduals(
        known.machine, known.runs, parameters, known.noise, root, starts=known.starts, scatter=known.scatter
    )
    x = np.append(base.fitted.x, np.zeros(len(nodes)))
    errors = residuals.at(x)
    steps = np.append(base.fitted.steps, first_steps(len(nodes)))
    columns, steps = residuals.jacobian(x, errors, steps, range(old, len(x)))
    jacobian = np.column_stack([np.vstack([base.fitted.jacobian, np.zeros((len(nodes), old))]), columns])
    fitted = Fitted(x, errors, jacobian, converged=False, steps=steps)
    return _weigh(Balance(effect.name, BalanceKind(effect.tabulated), 0.0, 0.0, 0.0, residuals, fitted))


def fit_table(base: Model, balance: Balance, min_gain: float = 0.0) -> Balance:
    """Fit a table together with the nuisances, the sizes of its nodes chosen anew where the first fit ends.

    `base` is the calibrated machine, `balance` that of `linearise_table`; it comes back with its ``model``. A fit that
    gains less than `min_gain` is not sharpened. Raises EndedEarly where the simulation fails where the linear model
    leads.
    """
    for number in range(MAX_ROUNDS):
        before, balance = balance, _weigh(balance)
        if number and not _is_resized(before.residuals.root, balance.residuals.root):
            balance = before
            break
        residuals = balance.residuals
        start, limit = balance.fitted, base.fitted.cost - min_gain + ROUGH
        fitted = descend(residuals, start.x, start.jacobian, start.steps, limit=limit)
        balance = balance._replace(fall=base.fitted.cost - fitted.cost, fitted=fitted)
        if not fitted.converged:
            break
    nodes = tuple(residuals.parameters[-len(residuals.root) :])
    return balance._replace(model=Model((*base.candidates, Candidate(balance.name, nodes, ())), residuals, fitted))


def _is_resized(root: np.ndarray, other: np.ndarray) -> bool:
    """Whether the size of a node differs by more than the factor `MAX_SIZE_RATIO`."""
    ratios = np.diag(root) / np.diag(other)
    return bool(np.any(np.maximum(ratios, 1.0 / ratios) > MAX_SIZE_RATIO))


def _weigh(balance: Balance) -> Balance:
    """The balance with the most probable sizes of its nodes, and the nodes to which they lead."""
    residuals, (x, errors, jacobian, _, steps) = balance.residuals, balance.fitted
    nodes = len(residuals.root)
    old = len(x) - nodes
    columns = jacobian[:-nodes, old:]
    projected = find_nuisance_space(jacobian[:-nodes, :old]).project_out(columns)
    branches = [parameter.key.rsplit("_at_", 1)[0] for parameter in residuals.parameters[old:]]
    gap, weighed = errors[:-nodes] - columns @ x[old:], []
    for trend in TRENDS:
        root = np.linalg.cholesky(correlate_nodes(branches, trend))
        sizes, fall, price, moved, shift = find_most_probable(projected @ root, gap, branches)
        weighed.append((sizes[:, None] * root, fall, price, moved, shift))
    root, fall, price, moved, shift = max(weighed, key=lambda row: row[1] - row[2])
    jacobian = np.vstack([jacobian[:-nodes], np.hstack([np.zeros((nodes, old)), np.linalg.inv(root)])])
    x = np.append(x[:old], root @ shift)
    fitted = Fitted(x, errors, jacobian, converged=False, steps=steps)
    return Balance(balance.name, balance.balance, fall, price, moved, residuals.with_root(root), fitted)


def find_most_probable(
    columns: np.ndarray, errors: np.ndarray, branches: Sequence[str]
) -> tuple[np.ndarray, float, float, float, np.ndarray]:
    """Find the sizes of the nodes, one for each branch, under which residuals are most probable.

    With the columns A (n, q) of the nodes, sensitivities to independent nodes of the size 1, the residuals e (n,)
    [standard deviations] and the sizes s, ``K = s A'A s`` and ``b = -s A'e``. The most probable nodes, over their
    sizes, then are ``x = (1 + K)^-1 b``, and the sizes are chosen for the largest ``fall - price``, with ``fall =
    x'b``, ``price = ln det(1 + K)`` and ``moved = trace((1 + K)^-1 K)``. It is the evidence of a linear model with a
    Gaussian prior: the price is MacKay's Occam factor, ``moved`` his number of well determined parameters (MacKay 1992,
    doi 10.1162/neco.1992.4.3.415). `branches` names the branch of each node; returned are sizes (q,), fall, price,
    moved and x (q,).
    """
    normal, seen, branch_of_node = columns.T @ columns, -columns.T @ errors, np.array(branches)

    def outcome(sizes: np.ndarray) -> tuple[float, float, float, np.ndarray]:
        scaled = sizes[:, None] * normal * sizes
        x = np.linalg.solve(np.eye(len(sizes)) + scaled, sizes * seen)
        price = np.linalg.slogdet(np.eye(len(sizes)) + scaled)[1]
        moved = np.trace(np.linalg.solve(np.eye(len(sizes)) + scaled, scaled))
        return float(x @ (sizes * seen)), float(price), float(moved), x

    def resize(sizes: np.ndarray, branch: str) -> list[np.ndarray]:
        return [np.where(branch_of_node == branch, size, sizes) for size in SIZES]

    def gain(sizes: np.ndarray) -> float:
        fall, price, *_ = outcome(sizes)
        return fall - price

    sizes = max((np.full(len(branches), size) for size in SIZES), key=gain)
    for _ in range(SWEEPS):
        for branch in dict.fromkeys(branches):
            sizes = max(resize(sizes, branch), key=gain)
    return sizes, *outcome(sizes)


def correlate_nodes(branches: Sequence[str], share: float) -> np.ndarray:
    """Correlate the nodes of a table by their prior (q, q), before anything is measured.

    Those of one branch have a share of their variance in common, a constant and a slope, so that a trend goes on where
    nothing was measured; what differs from it fades with their distance. `share` holds at the ends of a branch, where
    the diagonal is 1; `branches` names the branch of each node.
    """
    names, rank = np.array(branches), np.arange(len(branches))
    along = np.concatenate([np.linspace(-1.0, 1.0, list(branches).count(name)) for name in dict.fromkeys(branches)])
    same = names[:, None] == names[None, :]
    trend = 0.5 * (1.0 + along[:, None] * along[None, :])
    wild = np.exp(-np.abs(rank[:, None] - rank[None, :]) / CORRELATION_LENGTH)
    return same * (share * trend + (1.0 - share) * wild)
