"""What a case hides, of a size drawn by the deviations that it makes on the runs to fit."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tests.truth.simulator.effects import EFFECTS

from .foreign import CLUTTER, FOREIGN
from .library import ENGINE, LIBRARY, VALVE

LIMIT = 5.0
"""Deviations at which an effect counts as seen."""
SMALLEST, LARGEST = 0.5, 20.0
"""Sizes of what is hidden, over that limit."""
LITTLE = (0.2, 0.6)
"""Sizes of clutter, over that limit."""
NEAR = 1.15
"""Factor to the size asked for that is let pass."""
TRIES = 8
FIRST = 0.3
"""Share of the range that is tried first."""
ANEW = {VALVE: (0, 2), ENGINE: (0,)}
"""How often sensitivities are taken anew in each descent for the size that is told; an engine is slow, and its contacts
hardly move."""


class Hidden(NamedTuple):
    """What is hidden, and how it shows."""

    add: Callable
    """From rig to rig."""
    told: dict
    """What the answer says of it."""
    deviations: float
    left: np.ndarray
    """See `truth.sealed.observation.Laboratory.left`."""


def with_hidden(rig, hidden):
    """A rig with all that is hidden."""
    for one in hidden:
        rig = one.add(rig)
    return rig


def hidden_effect(rng, lab, nominal, points, name, min_size, *, straight=False, with_shape=None):
    """An effect of the library, at min_size of a size [limits].

    Parameters
    ----------
    rng : numpy.random.Generator
    lab : truth.sealed.observation.Laboratory
    nominal : truth.simulator.effects.Rig
    points : sequence of truth.sealed.setting.Point
    name : str
    min_size : float
        [limits]
    straight : bool
        Look for the size by sensitivities, see `sized`.
    with_shape : callable, optional
        Draws what a shape parameter is beside a strength [SI], of the generator and the effect's name.

    Returns
    -------
    Hidden
    """
    entry = LIBRARY[name]
    end = float(rng.choice(entry.ends))
    besides = {key: float(rng.uniform(*ends)) for key, ends in entry.besides.items()}
    shape = with_shape(rng, name) if with_shape else None

    def parameters(share):
        strength = entry.size(share, end) * entry.scale
        return besides | (shape(strength) if shape else {}) | {entry.parameter: strength}

    def add(share):
        return lambda rig: EFFECTS[name](rig, **parameters(share))

    share, deviations, left = sized(lab, nominal, points, add, drawn_size(rng, min_size, LARGEST), straight)
    told = {
        "name": name,
        "parameter": entry.parameter,
        "value": entry.size(share, end),
        "unit": entry.unit,
        "parameters": parameters(share),
        "deviations": deviations,
    }
    return Hidden(add(share), told, deviations, left)


def hidden_foreign(rng, lab, nominal, points, name, straight=False):
    """Physics that is in no library, well above the limit."""
    return of_share(lab, nominal, points, name, FOREIGN[name].draw(rng), drawn_size(rng, 2.0, LARGEST), straight)


def hidden_clutter(rng, lab, nominal, points, name, straight=False):
    """Physics that a good model leaves out."""
    return of_share(lab, nominal, points, name, CLUTTER[name](rng), drawn_size(rng, *LITTLE), straight)


def of_share(lab, nominal, points, name, with_share, wanted, straight=False):
    """What is hidden by its share of the largest size."""

    def add(share):
        return lambda rig: with_share(rig, share)

    share, deviations, left = sized(lab, nominal, points, add, wanted, straight)
    return Hidden(add(share), {"name": name, "share": share, "deviations": deviations}, deviations, left)


def drawn_size(rng, min_size, max_size):
    """A size, any order of magnitude alike; from limits to deviations."""
    return LIMIT * float(np.exp(rng.uniform(np.log(min_size), np.log(max_size))))


def sized(lab, nominal, points, add, wanted, straight=False):
    """The share of its range at which something makes the wanted deviations, or all of the range.

    straight: the sizes on the way are found with nuisances that act in proportion, which is soon done; the deviations
    at the end never are. Those are the least of several descents, as each may end where nuisances could take more: of
    12 N of Coulomb friction beside scatter one left 49 deviations and another 15.

    Returns
    -------
    share, deviations : float
    left : float array
    """
    share, tried = FIRST, []
    for _ in range(TRIES):
        left = lab.left(nominal, add(share), points, linear=straight)
        deviations = float(np.linalg.norm(left))
        tried.append((share, max(deviations, 1e-6)))
        if 1.0 / NEAR < deviations / wanted < NEAR or (share == 1.0 and deviations < wanted):
            break
        share = min(1.0, following(tried, wanted))
    descents = [lab.left(nominal, add(tried[-1][0]), points, anew=anew) for anew in ANEW[lab.setting.bench]]
    left = min(descents, key=np.linalg.norm)
    return tried[-1][0], float(np.linalg.norm(left)), left


def following(tried, wanted):
    """The share to try next: by the last two on a doubly logarithmic scale, else in proportion."""
    shares, sizes = np.log(np.array(tried)).T
    slope = 1.0
    if len(tried) > 1 and abs(shares[-1] - shares[-2]) > 1e-6:
        slope = np.clip((sizes[-1] - sizes[-2]) / (shares[-1] - shares[-2]), 0.5, 4.0)
    return float(np.exp(shares[-1] + np.clip((np.log(wanted) - sizes[-1]) / slope, -3.0, 3.0)))
