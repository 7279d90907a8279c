"""Sliders of the live page: which keys of a machine move, and how far."""

from collections.abc import Iterator
from math import ceil, floor, isfinite, isnan, log10
from typing import Any, NamedTuple

from apesim.engine.cylinder import CAM, EPV, IDEAL_VALVE
from apesim.engine.effects import library_of
from apesim.engine.machine import Machine
from apesim.quantities.trees import Leaf, ambient_of, overruled, schema

SPEED_KEY = "speed"
"""Name of the speed among the sliders: it is no key of a machine."""
LOWEST_SPEED, HIGHEST_SPEED = 300.0, 2400.0
"""Ends of the speed's slider [r/min], as the sweep has them by default."""
SPANS = {"deg": 90.0, "K": 60.0}
"""Numbers by which angles [deg] and temperatures [K] move to each side."""
FACTOR, PRESSURE_FACTOR = 2.0, 4.0
"""Factors by which any other number moves up and down; a gauge pressure moves down farther."""
STEPS = 200
"""Steps of a slider, about."""
FIRST_STRENGTH = 0.1
"""Strength of an effect that is switched on, as a share of its range: it is seen, and nothing stops."""
ALL = (EPV, CAM, IDEAL_VALVE)
"""All kinds of intake."""


class Movable(NamedTuple):
    """A key of the machine that has a slider."""

    key: str
    label: str
    group: str
    intakes: tuple[int, ...] = ALL
    """Kinds of intake for which it does anything."""


OPERATION, TIMING, ENGINE, VALVE = "Operating point", "Timing", "Engine", "Valve"
"""Groups of sliders, in the order of the page."""
MOVABLE = (
    Movable("supply.pressure", "supply pressure", OPERATION),
    Movable("supply.temperature", "supply temperature", OPERATION),
    Movable("supply.control_pressure", "control air pressure", OPERATION, (EPV,)),
    Movable("ambient.pressure", "ambient pressure", OPERATION),
    Movable("command.energise", "energise", TIMING, (EPV,)),
    Movable("command.release", "release", TIMING, (EPV,)),
    Movable("engine.cam.opens", "cam opens", TIMING, (CAM,)),
    Movable("engine.cam.closes", "cam closes", TIMING, (CAM,)),
    Movable("command.open_target", "ideal valve opens", TIMING),
    Movable("command.close_target", "ideal valve closes", TIMING),
    Movable("engine.exhaust.opens", "exhaust opens", TIMING),
    Movable("engine.exhaust.closes", "exhaust closes", TIMING),
    Movable("engine.bore", "bore", ENGINE),
    Movable("engine.stroke", "stroke", ENGINE),
    Movable("engine.compression_ratio", "compression ratio", ENGINE),
    Movable("engine.rod_length", "rod length", ENGINE),
    Movable("engine.exhaust.effective_area", "exhaust area", ENGINE),
    Movable("engine.receiver.volume", "receiver volume", ENGINE),
    Movable("valve.stroke", "valve stroke", VALVE, (EPV, CAM)),
    Movable("valve.piston_area", "piston area", VALVE, (EPV,)),
    Movable("valve.moving_mass", "moving mass", VALVE, (EPV,)),
    Movable("valve.spring_rate", "spring rate", VALVE, (EPV,)),
    Movable("valve.solenoid.effective_area", "solenoid area", VALVE, (EPV,)),
    Movable("valve.solenoid.dead_time", "solenoid dead time", VALVE, (EPV,)),
    Movable("groove.effective_area", "groove area", VALVE),
    Movable("groove.lap", "lap", VALVE, (EPV, CAM)),
)
"""Keys that have a slider; no other key is taken from a page."""


class Slider(NamedTuple):
    """Slider of a number, as the page draws it."""

    key: str
    label: str
    group: str
    unit: str
    """Unit of what is sent, with "gauge" or "abs" behind that of a pressure."""
    low: float
    high: float
    step: float
    value: float
    """Number that the machine has."""
    note: str = ""
    """Words for a value that is not given, such as "the supply's"; "": it is given."""


class EffectSliders(NamedTuple):
    """An effect that the page switches on: its sliders start at a strength that is seen."""

    name: str
    seen_in: str
    is_on: bool
    is_compiled_in: bool
    """Whether the march is compiled with it: the first run takes longer."""
    sliders: tuple[Slider, ...]


def sliders_of(machine: Machine, speed: float) -> list[Slider]:
    """Make the sliders of a machine at a speed [r/min], those of the operating point first."""
    leaves = {leaf.key: leaf for leaf in schema(type(machine), machine)}
    low, high = min(LOWEST_SPEED, floor(0.5 * speed)), max(HIGHEST_SPEED, ceil(1.5 * speed))
    first = Slider(SPEED_KEY, "speed", OPERATION, "rpm", low, high, 10.0, float(f"{speed:.10g}"))
    return [first, *_machine_sliders(machine, leaves)]


def _machine_sliders(machine: Machine, leaves: dict[str, Leaf]) -> Iterator[Slider]:
    """Sliders of the keys that do anything in this machine, and have a finite value."""
    idle = dict(overruled(machine))
    for key, label, group, intakes in MOVABLE:
        if machine.engine.intake not in intakes or key in idle:
            continue
        leaf, note = leaves[key], ""
        if key == "supply.control_pressure" and isnan(leaf.default):
            leaf, note = leaf._replace(default=machine.supply.pressure), "the supply's"
        if isfinite(leaf.default):
            yield slider_of(machine, leaf, label, group)._replace(note=note)


def slider_of(machine: Machine, leaf: Leaf, label: str, group: str) -> Slider:
    """Make the slider of a key: about its value, and within the range of the key."""
    text = leaf.declaration.render(leaf.default, ambient_of(machine))
    number, _, unit = (str(text) if isinstance(text, str) else repr(text)).partition(" ")
    value = float(number)
    own_low, own_high = leaf.declaration.low, leaf.declaration.high
    is_gauge = unit.endswith("gauge")
    if unit in SPANS:
        low, high = value - SPANS[unit], value + SPANS[unit]
    elif value:
        low, high = sorted((value / (PRESSURE_FACTOR if is_gauge else FACTOR), value * FACTOR))
    else:
        low, high = own_low, own_high
    if not is_gauge:  # the range of a key is that of the absolute pressure
        low, high = max(low, own_low), min(high, own_high)
    return _rounded(Slider(leaf.key, label, group, unit, low, high, 1.0, value))


def _rounded(slider: Slider) -> Slider:
    """Give a slider a round step; its ends stay within where they are, on steps."""
    wide = (slider.high - slider.low) / STEPS
    power = 10.0 ** floor(log10(wide))
    step = next(each * power for each in (1.0, 2.0, 5.0, 10.0) if each * power >= 0.999 * wide)
    low, high = ceil(slider.low / step - 1e-9) * step, floor(slider.high / step + 1e-9) * step
    return slider._replace(low=float(f"{low:.10g}"), high=float(f"{high:.10g}"), step=float(f"{step:.10g}"))


def effect_sliders(machine: Machine) -> list[EffectSliders]:
    """List the effects that change an engine's run, with sliders of their numbers; tables have too many."""
    found = []
    for effect in library_of(machine.effects):
        if effect.tabulated or effect.search.is_nuisance or not set(effect.slots) - {"sensor"}:
            continue
        parameters: Any = getattr(machine.effects, effect.name)
        is_on = effect.is_on(parameters)
        strengths = effect.strengths or (effect.parameters._fields[0],)  # type: ignore[attr-defined]
        sliders = []
        for leaf in schema(effect.parameters, parameters, f"effects.{effect.name}"):
            declaration, name = leaf.declaration, leaf.key.rpartition(".")[2]
            if not hasattr(declaration, "low") or not (isfinite(declaration.low) and isfinite(declaration.high)):
                continue
            slider = _range_slider(machine, leaf, name.replace("_", " "))
            if not is_on and name == strengths[0]:
                ends = slider.low, slider.high
                far = max(ends, key=lambda end: (abs(end - slider.value), end))
                slider = slider._replace(value=float(f"{slider.value + FIRST_STRENGTH * (far - slider.value):.6g}"))
            sliders.append(slider)
        found.append(EffectSliders(effect.name, effect.seen_in, is_on, effect.is_marched, tuple(sliders)))
    return found


def _range_slider(machine: Machine, leaf: Leaf, label: str) -> Slider:
    """Slider over all of the range of a key; a pressure that is shown as gauge stands above the ambient."""
    text = leaf.declaration.render(leaf.default, ambient_of(machine))
    number, _, unit = (str(text) if isinstance(text, str) else repr(text)).partition(" ")
    value, low, high = float(number), float(leaf.declaration.low), float(leaf.declaration.high)
    slider = _rounded(Slider(leaf.key, label, "Effects", unit, low, high, 1.0, value))
    return slider._replace(low=low, high=high)


def is_movable(machine: Machine, key: str) -> bool:
    """Whether a page may give a value for a key: nothing else of a machine file is taken from it, no path above all.

    >>> is_movable(Machine(), "engine.bore"), is_movable(Machine(), "effects.files")
    (True, False)
    """
    section, _, rest = key.partition(".")
    if section != "effects":
        return any(key == each.key for each in MOVABLE)
    return any(slider.key == key for effect in effect_sliders(machine) for slider in effect.sliders) and bool(rest)
