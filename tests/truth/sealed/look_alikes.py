"""Which effects of the library could stand in for what is hidden, as far as a case's sensors and runs can tell."""

from typing import NamedTuple

import numpy as np

from tests.truth.simulator.effects import EFFECTS

from .hiding import LIMIT, with_hidden
from .library import LIBRARY
from .nuisances import Nuisance

PROBE = 0.3
"""Share of an effect's range by which it is tried first."""
CLOSE = 3
"""How many of the best are fitted together with the nuisances."""
FAR = 0.7
"""Share of all deviations; what leaves more of many is not fitted."""
TOLD_APART = 9.2
"""Deviations squared by which two explanations have to differ: 99 % of a chi-square of two degrees of freedom."""


class LookAlike(NamedTuple):
    """An effect in place of what is hidden."""

    name: str
    left: float
    """Deviations that it leaves, at the size that suits best and lies in its range."""


def look_alikes(lab, nominal, points, hidden, known):
    """Every effect in place of what is hidden, the best first.

    A straight model tells which are close; those are fitted through the simulator, together with the nuisances.

    Parameters
    ----------
    lab : truth.sealed.observation.Laboratory
    nominal : truth.simulator.effects.Rig
    points : sequence of Point
        To fit.
    hidden : sequence of truth.sealed.hiding.Hidden
    known : sequence of str
        Effects that are tried.

    Returns
    -------
    list of LookAlike
    """
    entries = [LIBRARY[name] for name in known if lab.setting.bench in LIBRARY[name].benches]
    own = [one.told["name"] for one in hidden]
    left = sum(one.left for one in hidden)
    rough = sorted(((*straight(lab, nominal, points, left, entry), entry) for entry in entries), key=lambda one: one[0])
    near = max(2.0 * LIMIT, FAR * float(np.linalg.norm(left)))
    others = [(share, entry) for apart, share, entry in rough if share and [entry.name] != own and apart < near]
    close = {
        entry.name: LookAlike(entry.name, fitted(lab, nominal, points, hidden, entry, share))
        for share, entry in others[:CLOSE]
    }
    found = [
        LookAlike(entry.name, 0.0) if [entry.name] == own else close.get(entry.name, LookAlike(entry.name, apart))
        for apart, _, entry in rough
    ]
    return sorted(found, key=lambda one: one.left)


def straight(lab, nominal, points, left, entry):
    """What an effect leaves if all is straight, and at which share of its range."""
    own = lab.left(nominal, change_of(entry, PROBE), points, True, f"{entry.name} {PROBE:g}")
    scale = float(own @ own)
    share = PROBE * float(left @ own) / scale if scale > 0.0 else 0.0
    share = float(np.clip(share, *ends(entry)))
    return float(np.linalg.norm(lab.freed(nominal, points, left - share / PROBE * own))), share


def fitted(lab, nominal, points, hidden, entry, share):
    """What an effect leaves [deviations], fitted through the simulator from a share of its range on."""
    size = Nuisance(entry.name, PROBE, lambda rig, x: change_of(entry, x)(rig) if x else rig, ends=ends(entry))
    left = lab.left(nominal, lambda rig: with_hidden(rig, hidden), points, stand_in=size, start=share / PROBE)
    return float(np.linalg.norm(left))


def ends(entry):
    """Ends of the shares of an effect's range, below zero towards its first end."""
    return -1.0 if len(entry.ends) > 1 else 0.0, 1.0


def change_of(entry, share):
    """What an effect does to a rig at a share of its range."""
    value = entry.size(abs(share), entry.ends[0 if share < 0.0 else -1]) * entry.scale
    besides = {key: float(np.mean(ends)) for key, ends in entry.besides.items()}
    return lambda rig: EFFECTS[entry.name](rig, **besides | {entry.parameter: value})


def class_of(name, alike):
    """The named effect and those that leave less than can be told, by name."""
    return [name] + [one.name for one in alike if one.name != name and one.left**2 < TOLD_APART]
