"""The trial of an effect from outside: its slots are filled once, as the march would, before work depends on it.

A slot that fails would otherwise do so in the middle of a sweep, and with a fault that names no file.
"""

import re
from collections.abc import Callable
from typing import Any

import numba
import numpy as np

from apesim.effect import Effect, FedVolume, contact, law
from apesim.engine.angles import TURN
from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
from apesim.engine.cycle.state import cylinder_state, instant_at, receiver_state, supply_of
from apesim.engine.cylinder import TERM_NAMES as ENGINE_TERM_NAMES
from apesim.engine.effects.outside import OutsideEffect
from apesim.engine.machine import Machine
from apesim.kernel import outside_folder
from apesim.quantities import Fault, InputError
from apesim.quantities.trees import fields
from apesim.reading import Reading
from apesim.valve.actuator import state_of
from apesim.valve.terms import TERM_NAMES as VALVE_TERM_NAMES

SPEED = 1000.0 * TURN / 60.0
"""Speed of the engine on trial [rad/s]: any would do."""
PISTON_SPEED = -1.5
"""Speed of the valve's piston on trial [m/s]: in the middle of an opening stroke."""
TERM_NAMES = {"valve": VALVE_TERM_NAMES, "engine": ENGINE_TERM_NAMES}
"""Elements of the balance of each layer."""
CHANNELS = ("lift", "pressure_a", "pressure_b", "cylinder_pressure")
"""What the sensors on trial show."""


def try_effect(one: OutsideEffect) -> None:
    """Fill each slot of an effect from outside with numbers of the default machine.

    Raises InputError with one fault: a slot cannot be computed or compiled, or does something while the effect is off.

    >>> from apesim.engine.effects.outside import load_effect
    >>> try_effect(load_effect("docs/examples/data/tapered_bore.py"))
    """
    trials: dict[str, Callable] = {
        "law": _try_law,
        "contact": _try_contact,
        "adjust": _try_adjust,
        "volume": _try_volume,
        "sensor": _try_sensor,
    }
    for slot in one.effect.slots:
        try:
            wrong = trials[slot](one)
        except Exception as error:  # the code of a user raises anything
            wrong = f"fails: {_line(error)}"
        if wrong:
            raise InputError([Fault(str(one.path), "", f"EFFECT: its {slot} {wrong}", "mend the file")])


def _line(error: Exception) -> str:
    """What an error says, on one line; of the compiler's the lines that say what it cannot do."""
    plain = re.sub("\x1b\\[[0-9;]*m", "", str(error))  # without the colours of a terminal
    said = [line.strip() for line in plain.splitlines() if line.strip()]
    if isinstance(error, numba.core.errors.NumbaError):
        said = [line for line in said if not line.startswith(("Failed in", "File", "During:", "<source", "-"))][:2]
        return f"it cannot be compiled: {' '.join(said)}"
    return f"{type(error).__name__}: {' '.join(said)}"


def strong(effect: Effect) -> Any:
    """The parameters of an effect [SI] with each strength halfway between off and the farther end of its range."""
    values, declared = effect.parameters(), fields(effect.parameters)
    for name in effect.strengths or effect.parameters._fields[:1]:  # type: ignore[attr-defined]
        far = max(declared[name].ends, key=lambda end: abs(end - effect.off))
        values = values._replace(**{name: 0.5 * (effect.off + far)})
    return values


def sample_state(layer: str) -> Any:
    """What laws of a layer see of the default machine at an instant: of the valve, in the middle of a stroke.

    `layer` is "valve" or "engine"; gives a `ValveState` or a `CylinderState`.
    """
    p, _, _ = cycle_of(Machine(), SPEED)
    y, _ = charged_at_rest(p)
    if layer == "engine":
        cylinder, _ = cylinder_state(p, instant_at(p, 0.0, y), y)
        return cylinder._replace(air=cylinder.air._replace(pressure=3.0 * p.actuator.ambient.pressure))
    state = state_of(p.actuator, y, supply_of(p, y, receiver_state(p, y)))
    return state._replace(position=0.5 * p.actuator.valve.stroke, speed=PISTON_SPEED)


def _try_law(one: OutsideEffect) -> str:
    state = sample_state(one.effect.layer)
    names = TERM_NAMES[one.effect.layer]
    off, on, balance = one.effect.parameters(), strong(one.effect), np.zeros(len(names))
    law(off, state, balance)
    if balance.any():
        added = [name for name, value in zip(names, balance, strict=True) if value != 0.0]
        hint = "; note a branch only where its strength is not zero" if "BRANCH" in added else ""
        return f"adds to {' and '.join(added)} of the balance while it is off{hint}"
    law(on, state, balance)
    if not np.isfinite(balance).all():
        wrong = [name for name, value in zip(names, balance, strict=True) if not np.isfinite(value)]
        return f"adds what is no finite number to {' and '.join(wrong)} of the balance"
    return _compiled(one, "law", law.bodies[type(on)], (on, state, balance))


def _try_contact(one: OutsideEffect) -> str:
    off, on = one.effect.parameters(), strong(one.effect)
    if contact(off, 1.0) != 0.0:
        return "lets the piston rebound while it is off"
    if not 0.0 <= contact(on, 1.0) <= 1.0:
        return "is no restitution of 0 to 1"
    return _compiled(one, "contact", contact.bodies[type(on)], (on, 1.0))


def _compiled(one: OutsideEffect, slot: str, body: Callable, arguments: tuple) -> str:
    """Compile a slot once for each content of a file; raises what the compiler does."""
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return ""
    done = outside_folder(one.sha256[:16]) / f"{slot}.tried"
    if not done.exists():
        body.compiled.compile(tuple(map(numba.typeof, arguments)))  # type: ignore[attr-defined]
        done.touch()
    return ""


def _try_adjust(one: OutsideEffect) -> str:
    assert one.effect.adjust is not None
    p, tables, _ = cycle_of(Machine(), SPEED)
    given = (p, tables) if one.effect.layer == "engine" else (p.actuator, tables.valve)
    found = one.effect.adjust(strong(one.effect), *given)
    kinds = [type(each) for each in given]
    if not isinstance(found, tuple) or [type(each) for each in found] != kinds:
        return f"does not return a pair of {kinds[0].__name__} and {kinds[1].__name__}"
    return ""


def _try_volume(one: OutsideEffect) -> str:
    assert one.effect.volume is not None
    fed = FedVolume(*one.effect.volume(strong(one.effect)))
    if not (0.0 < fed.volume < np.inf and 0.0 < fed.feed_area < np.inf):
        return "gives no volume [m3] and area of its feed [m2] above zero"
    return ""


def _try_sensor(one: OutsideEffect) -> str:
    assert one.effect.sensor is not None

    def at(times: np.ndarray) -> dict[str, np.ndarray]:
        return {name: np.sin(100.0 * times) for name in CHANNELS}

    times = np.linspace(0.0, 0.01, 11)
    for speed, start in ((np.nan, np.nan), (SPEED, 0.0)):
        shown = one.effect.sensor(strong(one.effect), Reading(at, speed, start)).at(times)
        if set(shown) != set(CHANNELS) or any(np.shape(values) != times.shape for values in shown.values()):
            return "does not keep the channels of a reading"
    return ""
