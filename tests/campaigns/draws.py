"""Valid machines at random: near the default one, or wide, with every key over its whole range."""

from math import isinf, isnan, nan

import numpy as np

from apesim.engine.machine import Machine
from apesim.quantities import Curve
from apesim.quantities.declarations import Choice
from apesim.quantities.trees import faults, schema
from tests.machines import changed

SHARE_ON = 0.1
"""Share of the effects that are on."""
SHARE_NOT_GIVEN = 0.5
"""Share of those keys left out that may be left out."""
SHARE_OF_CURVES = 0.1
"""Share of the curves that are given, and of the volumes that are infinite."""
NEAR = 0.6
"""Share of a default, up or down, over which a narrow machine's keys are drawn."""
WIDE = 20.0
"""Ratio of the ends of a range from which on it is drawn on a logarithmic scale."""
WITHOUT_END = 1e6
"""Ratio that stands for an upper end that is infinite."""
ATTEMPTS = 1000
"""Drawings of the keys that contradict one another."""
UNUSED = (
    *("known_to", "rig", "shaft", "load", "stage_2", "inter_receiver", "cylinder"),
    *("engine.cylinders", "engine.phases"),
)
"""Sections and keys that no march of one cylinder at constant speed reads."""


def draw_machine(rng, is_wide):
    """Draw a valid machine.

    Parameters
    ----------
    rng : numpy.random.Generator
    is_wide : bool
        Whether each key is drawn over its whole range, or within `NEAR` of its default.

    Returns
    -------
    Machine
    """
    unused = tuple(f"{name}." for name in UNUSED)
    leaves = {leaf.key: leaf for leaf in schema(Machine) if not f"{leaf.key}.".startswith(unused)}
    on = {f"effects.{name}" for name in Machine().effects._fields if rng.random() < SHARE_ON}

    def draw(keys):
        return {key: draw_value(rng, leaves[key], is_wide) for key in keys}

    def group_of(key):
        parts = key.split(".")
        return ".".join(parts[:2] if parts[0] == "effects" else parts[:-1])

    machine = changed(Machine(), draw(key for key in leaves if not key.startswith("effects.") or group_of(key) in on))
    for _ in range(ATTEMPTS):
        wrong = {key for key, _, _ in faults(machine)}
        if not wrong:
            return machine
        groups = {group_of(key) for key in wrong}
        machine = changed(machine, draw(key for key in leaves if group_of(key) in groups))
    raise AssertionError(f"no machine without faults: {sorted(wrong)}")


def draw_value(rng, leaf, is_wide):
    """Draw the value of one key, SI."""
    declaration = leaf.declaration
    if isinstance(declaration, Curve):
        return CURVES[leaf.key](rng) if rng.random() < SHARE_OF_CURVES else leaf.default
    if isinstance(declaration, Choice):
        return int(rng.integers(len(declaration.options)))
    if declaration.optional and rng.random() < SHARE_NOT_GIVEN:
        return nan
    low, high = declaration.ends
    if isinf(high):
        if rng.random() < SHARE_OF_CURVES:
            return high
        high = WITHOUT_END * low
    if not is_wide and not isnan(leaf.default):
        low, high = narrow(leaf.default, low, high)
    value = (
        np.exp(rng.uniform(np.log(low), np.log(high))) if low > 0.0 and high > WIDE * low else rng.uniform(low, high)
    )
    return float(np.clip(round(value) if declaration.whole else value, low, high))


def draw_log(rng, low, high):
    """Draw a number evenly on a logarithmic scale."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def narrow(default, low, high):
    """Ends of a range near a default; a tenth of the range where the default is 0."""
    reach = NEAR * abs(default) or 0.1 * (high - low)
    return max(low, default - reach), min(high, default + reach)


def rising(rng, last, top=1.0):
    """A curve that rises from 0 to its top at a time or lift, with kinks at random."""
    inside = int(rng.integers(4))
    x = np.concatenate([[0.0], np.sort(rng.uniform(0.05, 0.95, inside)), [1.0]])
    y = np.concatenate([[0.0], np.sort(rng.random(inside)), [1.0]])
    return np.column_stack([last * x, top * y])


def lifting(rng):
    """Lift of a cam over the crank angle, up and down."""
    up = rising(rng, np.radians(rng.uniform(10.0, 120.0)), rng.uniform(1e-3, 15e-3))
    down = np.column_stack([2.0 * up[-1, 0] - up[-2::-1, 0], up[-2::-1, 1]])
    curve = np.concatenate([up, down])
    curve[:, 0] += np.radians(rng.uniform(-60.0, 30.0))
    return curve


CURVES = {
    "valve.solenoid.opening_curve": lambda rng: rising(rng, rng.uniform(0.2e-3, 10e-3)),
    "valve.solenoid.release_curve": lambda rng: rising(rng, rng.uniform(0.2e-3, 10e-3)),
    "groove.area_curve": lambda rng: rising(rng, rng.uniform(1e-3, 20e-3), rng.uniform(10e-6, 500e-6)),
    "engine.cam.lift_curve": lifting,
}
"""Drawings of the curves, SI."""
