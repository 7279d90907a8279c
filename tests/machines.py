"""Machines for the tests, from arguments in the units of the field; what is not named stands at its default.

The receiver is infinite unless named, as in the published reference solutions.
"""

import csv
from math import inf, isnan, nan, pi
from typing import get_type_hints

from apesim.engine.angles import DEGREE
from apesim.engine.cylinder import INTAKES
from apesim.engine.machine import Machine
from apesim.engine.steady import run_steady
from tests.folders import ACCEPTANCE

AMBIENT = 101325.0
RPM = pi / 30.0


def changed(machine, values):
    """A machine with other values, SI, by the names that a machine file uses: ``{"engine.cam.lift": 5e-3}``."""
    for name, value in values.items():
        machine = _changed(machine, name.split("."), value)
    return machine


def _changed(section, path, value):
    if len(path) > 1:
        value = _changed(getattr(section, path[0]), path[1:], value)
    return section._replace(**{path[0]: value})


def machine(
    intake="epv",
    supply=1.0,
    temperature=287.0,
    energise=-5.0,
    release=70.0,
    targets=(-5.0, 70.0),
    receiver=inf,
    control_air="regulator",
    **values,
):
    """A machine.

    Parameters
    ----------
    intake, control_air : str
        As in a machine file.
    supply : float
        [MPa gauge]
    temperature : float
        Of the supply [K].
    energise, release : float
        [deg]
    targets : pair of float
        Intended opening and closing [deg].
    receiver : float
        Volume [L].
    **values
        Other values by name, SI, with a double underscore for the dot: ``engine__cam__lift=5e-3``.
    """
    return changed(
        Machine(),
        {
            "engine.intake": INTAKES.index(intake),
            "supply.pressure": supply * 1e6 + AMBIENT,
            "supply.temperature": temperature,
            "supply.control_air": ("regulator", "receiver").index(control_air),
            "command.energise": energise * DEGREE,
            "command.release": release * DEGREE,
            "command.open_target": targets[0] * DEGREE,
            "command.close_target": targets[1] * DEGREE,
            "engine.receiver.volume": receiver * 1e-3,
        }
        | {name.replace("__", "."): value for name, value in values.items()},
    )


def settled(a_machine, rpm, **options):
    """The machine's periodic state at a speed [r/min]; that it was reached is made sure of."""
    run = run_steady(a_machine, rpm * RPM, **options)
    assert run.status == 0
    assert run.orbit.converged
    return run


def reference(name):
    """Rows of a published reference, text as printed, each a dict by column."""
    with (ACCEPTANCE / name).open(newline="") as file:
        return list(csv.DictReader(file))


def printed(text):
    """Value of a printed number, and half a unit of its last digit; NaN where there is none."""
    if not text:
        return nan, 0.0
    return float(text), 0.5 * 10.0 ** -len(text.partition(".")[2])


def agrees(found, text, share=0.0, by=0.0):
    """Whether a number is the printed one, within a share of it and an amount, and half a unit of its last digit."""
    value, half = printed(text)
    if isnan(value):
        return isnan(found)
    return abs(found - value) <= share * abs(value) + by + half


def turned_on(effect, share=0.5):
    """Parameters of an effect, its strengths a share of the way from doing nothing to the farther end of their range.

    Parameters
    ----------
    effect : apesim.effect.Effect
    share : float

    Returns
    -------
    NamedTuple
    """
    hints = get_type_hints(effect.parameters, include_extras=True)
    values = {}
    for name in effect.strengths or effect.parameters._fields[:1]:
        end = max(hints[name].__metadata__[0].ends, key=lambda end: abs(end - effect.off))
        values[name] = effect.off + share * (end - effect.off)
    return effect.parameters(**values)
