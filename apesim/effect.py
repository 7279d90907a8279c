"""What an effect is: physics, or an error of the machine file, that the base model leaves out.

An effect is one file with its parameters and one or more of the slots below. Its parameters are a NamedTuple whose
first field is the strength; at strength 0 (or another that the effect names) it changes no bit of any result.
"""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from numba.extending import overload

from apesim.kernel import by_type, kernel


@by_type
def law(effect, state, balance):
    """Slot: add to the balances of force, mass and heat, given the state of the machine."""


@by_type
def contact(effect, speed):
    """Slot: restitution of a stop that is met at a speed [m/s]."""
    return 0.0


class Effect(NamedTuple):
    """An effect as the library lists it."""

    name: str
    parameters: type
    """NamedTuple of the parameters, the first of them the strength."""
    equation: str
    source: str
    seen_in: str
    isolated_by: str
    strengths: tuple = ()
    """Names of the strengths where there is more than the first parameter."""
    adjust: Callable | None = None
    """Slot: (parameters, machine, tables) -> machine, tables with other parameters, before the march."""
    volume: Callable | None = None
    """Slot: parameters -> a gas volume more [m3], which the base model has a place for, and the effective area through
    which it is fed [m2]."""
    sensor: Callable | None = None
    """Slot: (parameters, reading) -> reading that is taken otherwise, see `apesim.reading`; the march knows nothing."""
    off: float = 0.0
    """Strength at which the effect does nothing."""
    tabulated: str = ""
    """Balance that it is a table of: it can close a gap there, and names nothing; "": it is a law."""
    layer: str = ""
    """Layer whose balances and parameters an effect from outside acts on, "valve" or "engine"; "": it is one of ours,
    and its list says so."""

    @property
    def is_from_outside(self) -> bool:
        """Whether it stands in a file that a user has named or installed, see `apesim.engine.effects.outside`."""
        return bool(self.layer)

    def is_on(self, parameters):
        """Whether a strength among the parameters is another than that of doing nothing."""
        return any(getattr(parameters, name) != self.off for name in self.strengths or parameters._fields[:1])

    @property
    def slots(self):
        """Names of its slots."""
        filled = {
            "adjust": self.adjust is not None,
            "law": self.parameters in law.bodies,
            "contact": self.parameters in contact.bodies,
            "volume": self.volume is not None,
            "sensor": self.sensor is not None,
        }
        return tuple(slot for slot, is_filled in filled.items() if is_filled)

    @property
    def is_marched(self):
        """Whether it acts within the march, not only before or after it."""
        return bool(set(self.slots) - {"adjust", "sensor"})


class NoEffects(NamedTuple):
    """In place of a library's laws where none is on: the march is compiled without any."""


class Library(NamedTuple):
    """The effects of a layer, and what its marches are compiled for."""

    effects: tuple[Effect, ...]
    marches: tuple[type, ...]
    """NamedTuple type of the laws by kind of march, see `kind_of_march`."""


def acting(name: str, module: str, library: Iterable[Effect], tables: bool = False, outside: bool = False) -> type:
    """NamedTuple type of the parameters of those effects that act within the march.

    The compile cache finds a type again by the module that it says it is from, and by its name there.

    Parameters
    ----------
    name, module : str
    library : sequence of Effect
    tables : bool
        With those that are tabulated, too.
    outside : bool
        With those from outside, too.

    Returns
    -------
    type
    """
    own = [
        effect
        for effect in library
        if effect.is_marched and (tables or not effect.tabulated) and (outside or not effect.is_from_outside)
    ]
    found = NamedTuple(name, [(effect.name, effect.parameters) for effect in own])  # type: ignore[misc]
    found.__module__ = module
    return found


def library_for(effects: Any, own: Library, layer: str) -> Library:
    """The library of a layer that a machine's effects are of.

    Parameters
    ----------
    effects : NamedTuple
        Parameters by name of effect. Where some of them are from outside, its class has ``libraries``: the `Library`
        by name of layer.
    own : Library
        What holds where none is.
    layer : str
        "valve" or "engine".

    Returns
    -------
    Library
    """
    return getattr(effects, "libraries", {}).get(layer, own)


def kind_of_march(library: Iterable[Effect], effects: Any) -> int:
    """Which laws of a library a march needs; parameters by name of effect.

    Returns
    -------
    int
        0: none, 1: all of ours but tables, 2: all of ours; 3: all but tables, those from outside among them, 4: all.
    """
    on = [effect for effect in library if effect.is_on(getattr(effects, effect.name)) and effect.is_marched]
    is_tabulated = any(effect.tabulated for effect in on)
    if any(effect.is_from_outside for effect in on):
        return 3 + is_tabulated
    return 2 if is_tabulated else int(bool(on))


def chosen(library: Library, effects: Any, kind: int = 0) -> Any:
    """The effects of one library that act within the march.

    Parameters
    ----------
    library : Library
    effects : NamedTuple
        Parameters by name of effect; may hold those of other libraries too.
    kind : int
        What another library needs, see `kind_of_march`: the march is compiled with no less of this one, so that there
        are three kinds of march to compile and not nine; with effects from outside, two more.

    Returns
    -------
    NamedTuple
        Of one of the types of the library's marches; `NoEffects` where none is on.
    """
    container = library.marches[max(kind, kind_of_march(library.effects, effects))]
    return container(*(getattr(effects, name) for name in container._fields))  # type: ignore[attr-defined]


def volume_of(library, effects):
    """The gas volume that an effect of a library adds.

    Parameters
    ----------
    library : tuple of Effect
        One at most with that slot.
    effects : NamedTuple
        Parameters by name of effect.

    Returns
    -------
    volume, area : float
        [m3] and the effective area of its feed [m2]; both 0 where there is none.
    """
    for effect in library:
        values = getattr(effects, effect.name)
        if effect.volume and effect.is_on(values):
            return effect.volume(values)
    return 0.0, 0.0


def unserved(library, effects, marched, served):
    """Effects of a library that would be ignored: nothing that is computed knows them.

    Parameters
    ----------
    library : sequence of Effect
    effects : NamedTuple
        Parameters by name of effect.
    marched : dict
        Parameter class by name of effect, of those that the marches are compiled for, see `acting`.
    served : set of str
        Slots that are looked at for this library.

    Yields
    ------
    str
        The name of an effect that the machine has no place for; or that is on, without a slot, in one that is not
        served, or not among those marched; or that adds a second gas volume.
    """
    volumes = 0
    for effect in library:
        values = getattr(effects, effect.name, None)
        if values is not None and not effect.is_on(values):
            continue
        slots = set(effect.slots)
        volumes += effect.volume is not None
        is_left_out = effect.is_marched and marched.get(effect.name) is not effect.parameters
        if values is None or not slots or slots - served or is_left_out or (effect.volume and volumes > 1):
            yield effect.name


def adjusted(library, effects, machine, tables):
    """A machine after every `adjust` of a library that is on.

    Parameters
    ----------
    library : tuple of Effect
    effects : NamedTuple
        Parameters by name of effect.
    machine, tables : NamedTuple
        Numbers and arrays, as the kernels see them.

    Returns
    -------
    machine, tables : NamedTuple
    """
    for effect in library:
        values = getattr(effects, effect.name)
        if effect.adjust and effect.is_on(values):
            machine, tables = effect.adjust(values, machine, tables)
    return machine, tables


def sensed(library, effects, reading):
    """A reading after every `sensor` of a library that is on.

    Parameters
    ----------
    library : tuple of Effect
    effects : NamedTuple
        Parameters by name of effect.
    reading : apesim.reading.Reading

    Returns
    -------
    apesim.reading.Reading
    """
    for effect in library:
        values = getattr(effects, effect.name)
        if effect.sensor and effect.is_on(values):
            reading = effect.sensor(values, reading)
    return reading


def add_laws(effects, state, balance):
    """Let every effect of a tuple add to the balances."""
    for effect in effects:
        law(effect, state, balance)


@overload(add_laws)
def _add_laws(effects, state, balance):
    if len(effects) == 0:
        return lambda effects, state, balance: None

    def add(effects, state, balance):
        law(effects[0], state, balance)
        add_laws(effects[1:], state, balance)

    return add


@kernel
def note_branch(balance, index, branch):
    """Say on which branch of its law an effect is, where it has several: an integer of -3 to 3, a digit each.

    Where the number in the balance changes, the march ends a step.
    """
    balance[index] = 7.0 * balance[index] + branch


def restitution(effects, speed):
    """Largest restitution that any effect of a tuple gives a stop."""
    return max([contact(effect, speed) for effect in effects], default=0.0)


@overload(restitution)
def _restitution(effects, speed):
    if len(effects) == 0:
        return lambda effects, speed: 0.0

    def largest(effects, speed):
        return max(contact(effects[0], speed), restitution(effects[1:], speed))

    return largest
