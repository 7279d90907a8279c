"""Which effects of the library could stand in for what is hidden, as far as a case's sensors and runs can tell."""

from typing import NamedTuple

import numpy as np

from .effects import EFFECTS
from .library import LIBRARY

PROBE = 0.3
"""Share of an effect's range by which it is tried first."""
CLOSE = 5
"""How many of the best are tried again, at the size that suited best."""
TOLD_APART = 9.2
"""Deviations squared by which two explanations have to differ: 99 % of a chi-square of two degrees of freedom."""


class LookAlike(NamedTuple):
    """An effect in place of what is hidden."""

    name: str
    left: float
    """Deviations that it leaves, at the size that suits best and lies in its range."""
    share: float
    """That size, as a share of the range; negative towards its first end."""


def look_alikes(lab, nominal, points, left, known):
    """Every effect in place of what is hidden, the best first; the best few are tried twice, at the size that suited.

    Parameters
    ----------
    lab : truth.observation.Laboratory
    nominal : truth.effects.Rig
    points : sequence of Point
        To fit.
    left : float array
        What the hidden leaves, see `truth.observation.Laboratory.left`.
    known : sequence of str
        Effects that are tried.

    Returns
    -------
    list of LookAlike
    """
    entries = [LIBRARY[name] for name in known if lab.setting.bench in LIBRARY[name].benches]
    found = sorted(
        (alike(lab, nominal, points, left, entry, PROBE, True) for entry in entries), key=lambda one: one.left
    )
    again = [alike(lab, nominal, points, left, LIBRARY[one.name], one.share) for one in found[:CLOSE] if one.share]
    better = {one.name: one for one in again}
    found = [min(one, better.get(one.name, one), key=lambda each: each.left) for one in found]
    return sorted(found, key=lambda one: one.left)


def alike(lab, nominal, points, left, entry, share, linear=False):
    """An effect tried at a share of its range, towards the other end where that is negative."""
    label = f"{entry.name} {share:g}" if linear else ""
    own = lab.left(nominal, change_of(entry, share), points, linear, label)
    scale = float(own @ own)
    factor = float(left @ own) / scale if scale > 0.0 else 0.0
    suited = float(np.clip(factor * share, -1.0 if len(entry.ends) > 1 else 0.0, 1.0))
    apart = lab.freed(nominal, points, left - suited / share * own)
    return LookAlike(entry.name, float(np.linalg.norm(apart)), suited)


def change_of(entry, share):
    """What an effect does to a rig at a share of its range."""
    value = entry.size(abs(share), entry.ends[0 if share < 0.0 else -1]) * entry.scale
    besides = {key: float(np.mean(ends)) for key, ends in entry.besides.items()}
    return lambda rig: EFFECTS[entry.name](rig, **besides | {entry.parameter: value})


def class_of(name, alike):
    """The named effect and those that leave less than can be told, by name."""
    return [name] + [one.name for one in alike if one.name != name and one.left**2 < TOLD_APART]
