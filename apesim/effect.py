"""What an effect is: physics, or an error of the machine file, that the base model leaves out.

An effect is one file with its parameters and one or more of the slots below. Its parameters are a NamedTuple whose
first field is the strength; at strength 0 (or another that the effect names) it changes no bit of any result.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Set
from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload

from apesim.kernel import by_type, kernel


@by_type
def law(effect: Any, state: Any, balance: np.ndarray) -> None:
    """Add to the balances of force, mass and heat, given the state of the machine: a slot, empty here.

    Parameters
    ----------
    effect : NamedTuple
        Parameters of an effect; their type chooses the body, see ``law.for_type``.
    state : NamedTuple
        State of the machine, in SI.
    balance : (n,) array
        Balances and branches of the layer, in SI; added to.

    Examples
    --------
    >>> class Drag(NamedTuple):
    ...     factor: float = 0.0
    >>> @law.for_type(Drag)
    ... def add_drag(effect, state, balance):
    ...     balance[0] -= effect.factor * state.speed
    >>> class State(NamedTuple):
    ...     speed: float
    >>> balance = np.zeros(1)
    >>> law(Drag(factor=2.0), State(speed=3.0), balance)
    >>> balance.tolist()
    [-6.0]
    """


@by_type
def contact(effect: Any, speed: float) -> float:
    """Return the restitution of a stop that is met at a speed: a slot, 0 where nothing is registered.

    Parameters
    ----------
    effect : NamedTuple
        Parameters of an effect; their type chooses the body, see ``contact.for_type``.
    speed : float
        Speed of the contact without sign [m/s].

    Returns
    -------
    float
        Speed after over speed before the contact.

    Examples
    --------
    >>> class Soft(NamedTuple):
    ...     share: float = 0.0
    >>> @contact.for_type(Soft)
    ... def restitution_of_soft(effect, speed):
    ...     return effect.share
    >>> contact(Soft(share=0.3), 2.0)
    0.3
    """
    return 0.0


class Misstated(NamedTuple):
    """A number of the machine file of which an error does the same as an effect."""

    key: str
    """Key of the machine file."""
    correct: Callable[[float, float], float]
    """(number of the file, strength of the effect) -> number that does without the effect, SI."""


def scale(number: float, share: float) -> float:
    """Return a number that is off by a share of it, for `Misstated.correct`.

    Parameters
    ----------
    number : float
        Number of the machine file, SI.
    share : float
        Strength of the effect.

    Returns
    -------
    float
        Number that does without the effect.

    Examples
    --------
    >>> scale(2.0, 0.25)
    2.5
    """
    return (1.0 + share) * number


class Search(NamedTuple):
    """How `apesim gap explain` looks for an effect, where that is not as for most."""

    shapes: tuple[str, ...] = ()
    """Parameters beside the strengths that a fit may free."""
    unseen_on_rig: tuple[str, ...] = ()
    """Those of them that a cylinder moved by a drive cannot show: its piston never rests where it is looked at."""
    strengths: tuple[str, ...] = ()
    """Strengths that are searched for, where they are not all."""
    min_area: float = 0.0
    """Least area of a strength that does the less the larger it is [m2]; 0: it is no such area."""
    sizes: tuple[float, ...] = ()
    """Sizes of probes, over the range of the strength, for an effect whose slope at zero vanishes; (): the usual."""
    is_nuisance: bool = False
    """Whether it is no physics to be named, but an error of the record that is known within a prior."""
    isolated_on_rig: str = ""
    """Measurement that tells it from others on a cylinder moved by a drive; "": as on the valve's bench."""
    misstated: tuple[Misstated, ...] = ()
    """Numbers of the machine file that do the same where all of them are wrong together."""


class Effect(NamedTuple):
    """An effect as the library lists it: its name, parameters, description and slots."""

    name: str
    """Name of the effect, and of its section in a machine file."""
    parameters: type
    """NamedTuple of the parameters, the first of them the strength."""
    equation: str
    """What it computes, as a formula."""
    source: str
    """Source of the equation."""
    seen_in: str
    """Parts of a record in which it shows."""
    isolated_by: str
    """Measurement that tells it from other effects."""
    strengths: tuple = ()
    """Names of the strengths where there is more than the first parameter."""
    adjust: Callable | None = None
    """Slot: (parameters, machine, tables) -> machine, tables with other parameters, before the march."""
    volume: Callable | None = None
    """Slot: parameters -> a gas volume more, which the base model has a place for, with its feed: a `FedVolume`."""
    sensor: Callable | None = None
    """Slot: (parameters, reading) -> reading that is taken otherwise, see `apesim.reading`; the march knows nothing."""
    off: float = 0.0
    """Strength at which the effect does nothing."""
    tabulated: str = ""
    """Balance that it is a table of: it can close a gap there, and names nothing; "": it is a law."""
    layer: str = ""
    """Layer whose balances and parameters an effect from outside acts on, "valve" or "engine"; "": it is one of ours,
    and its list says so."""
    search: Search = Search()
    """How `apesim gap explain` looks for it."""

    @property
    def is_from_outside(self) -> bool:
        """Whether it stands in a file that a user has named or installed, see `apesim.engine.effects.outside`."""
        return bool(self.layer)

    def is_on(self, parameters: Any) -> bool:
        """Return whether a strength among the parameters is another than that of doing nothing.

        Parameters
        ----------
        parameters : NamedTuple
            Parameters of the effect.

        Returns
        -------
        bool
            Whether the effect changes a result.

        Examples
        --------
        >>> class Drag(NamedTuple):
        ...     factor: float = 0.0
        >>> drag = Effect("drag", Drag, "F = -k v", "chosen", "a slower stroke", "strokes at two speeds")
        >>> drag.is_on(Drag()), drag.is_on(Drag(factor=2.0))
        (False, True)
        """
        if not self.strengths:  # most effects; a march asks each of them several times
            return bool(parameters[0] != self.off)
        for name in self.strengths:  # noqa: SIM110 - `any` of a generator takes thrice as long
            if getattr(parameters, name) != self.off:
                return True
        return False

    @property
    def slots(self) -> tuple[str, ...]:
        """Names of the slots that it fills: adjust, law, contact, volume, sensor."""
        filled = {
            "adjust": self.adjust is not None,
            "law": self.parameters in law.bodies,
            "contact": self.parameters in contact.bodies,
            "volume": self.volume is not None,
            "sensor": self.sensor is not None,
        }
        return tuple(slot for slot, is_filled in filled.items() if is_filled)

    @property
    def is_marched(self) -> bool:
        """Whether it fills a slot of the march, not only adjust or sensor."""
        return bool(set(self.slots) - {"adjust", "sensor"})


class NoEffects(NamedTuple):
    """In place of a library's laws where none is on: the march is compiled without any."""


class Library(NamedTuple):
    """The effects of a layer, and what its marches are compiled for."""

    effects: tuple[Effect, ...]
    """Effects in the order of their list."""
    marches: tuple[type, ...]
    """NamedTuple type of the laws by kind of march, see `kind_of_march`."""


def acting(name: str, module: str, library: Iterable[Effect], tables: bool = False, outside: bool = False) -> type:
    """Return the NamedTuple type of the parameters of those effects that act within the march.

    The compile cache finds a type again by the module that it says it is from, and by its name there.

    Parameters
    ----------
    name, module : str
        Name of the type, and of the module that it is to be found in.
    library : sequence of Effect
        Effects of a layer.
    tables : bool
        Whether those that are tabulated are among them.
    outside : bool
        Whether those from outside are among them.

    Returns
    -------
    type
        NamedTuple with a field for each effect, in their order.

    Examples
    --------
    >>> class Drag(NamedTuple):
    ...     factor: float = 0.0
    >>> @law.for_type(Drag)
    ... def add_drag(effect, state, balance):
    ...     balance[0] -= effect.factor * state.speed
    >>> drag = Effect("drag", Drag, "F = -k v", "chosen", "a slower stroke", "strokes at two speeds")
    >>> class Effects(NamedTuple):
    ...     drag: Drag = Drag()
    >>> acting("Laws", "__main__", [drag])._fields
    ('drag',)
    """
    own = [
        effect
        for effect in library
        if effect.is_marched and (tables or not effect.tabulated) and (outside or not effect.is_from_outside)
    ]
    found = NamedTuple(name, [(effect.name, effect.parameters) for effect in own])  # type: ignore[misc]
    found.__module__ = module
    found.is_of_laws = True  # type: ignore[attr-defined]  # what `apesim.compiling` knows a march with effects by
    return found


def library_for(effects: Any, own: Library, layer: str) -> Library:
    """Return the library of a layer that a machine's effects belong to.

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
        Effects and marches of the layer.

    Examples
    --------
    >>> class Drag(NamedTuple):
    ...     factor: float = 0.0
    >>> @law.for_type(Drag)
    ... def add_drag(effect, state, balance):
    ...     balance[0] -= effect.factor * state.speed
    >>> drag = Effect("drag", Drag, "F = -k v", "chosen", "a slower stroke", "strokes at two speeds")
    >>> class Effects(NamedTuple):
    ...     drag: Drag = Drag()
    >>> own = Library((drag,), (NoEffects, acting("Laws", "__main__", [drag])))
    >>> library_for(Effects(), own, "valve") is own
    True
    """
    return getattr(effects, "libraries", {}).get(layer, own)


def kind_of_march(library: Iterable[Effect], effects: Any) -> int:
    """Return which laws of a library a march needs.

    Parameters
    ----------
    library : iterable of Effect
        Effects of a layer.
    effects : NamedTuple
        Parameters by name of effect.

    Returns
    -------
    int
        0: none, 1: all of ours but tables, 2: all of ours; 3: all but tables, those from outside among them, 4: all.

    Examples
    --------
    >>> class Drag(NamedTuple):
    ...     factor: float = 0.0
    >>> @law.for_type(Drag)
    ... def add_drag(effect, state, balance):
    ...     balance[0] -= effect.factor * state.speed
    >>> drag = Effect("drag", Drag, "F = -k v", "chosen", "a slower stroke", "strokes at two speeds")
    >>> class Effects(NamedTuple):
    ...     drag: Drag = Drag()
    >>> kind_of_march([drag], Effects()), kind_of_march([drag], Effects(Drag(factor=2.0)))
    (0, 1)
    """
    on = [effect for effect in library if effect.is_on(getattr(effects, effect.name)) and effect.is_marched]
    is_tabulated = any(effect.tabulated for effect in on)
    if any(effect.is_from_outside for effect in on):
        return 3 + is_tabulated
    return 2 if is_tabulated else int(bool(on))


def chosen(library: Library, effects: Any, kind: int = 0) -> Any:
    """Return the effects of one library that act within the march.

    Parameters
    ----------
    library : Library
        Effects and marches of a layer.
    effects : NamedTuple
        Parameters by name of effect; may hold those of other libraries too.
    kind : int
        What another library needs, see `kind_of_march`: the march is compiled with no less of this one, so that there
        are three kinds of march to compile and not nine; with effects from outside, two more.

    Returns
    -------
    NamedTuple
        Parameters by name of effect, of one of the types of the library's marches; `NoEffects` where none is on.

    Examples
    --------
    >>> class Drag(NamedTuple):
    ...     factor: float = 0.0
    >>> @law.for_type(Drag)
    ... def add_drag(effect, state, balance):
    ...     balance[0] -= effect.factor * state.speed
    >>> drag = Effect("drag", Drag, "F = -k v", "chosen", "a slower stroke", "strokes at two speeds")
    >>> class Effects(NamedTuple):
    ...     drag: Drag = Drag()
    >>> own = Library((drag,), (NoEffects, acting("Laws", "__main__", [drag])))
    >>> chosen(own, Effects()), chosen(own, Effects(Drag(factor=2.0)))
    (NoEffects(), Laws(drag=Drag(factor=2.0)))
    """
    container = library.marches[max(kind, kind_of_march(library.effects, effects))]
    return container(*(getattr(effects, name) for name in container._fields))  # type: ignore[attr-defined]


class FedVolume(NamedTuple):
    """Gas volume that an effect puts before a flow, with its feed; zeros where there is none."""

    volume: float
    """Gas volume [m3]."""
    feed_area: float
    """Effective area of its feed [m2]."""


def volume_of(library: Iterable[Effect], effects: Any) -> FedVolume:
    """Return the gas volume that an effect of a library adds.

    Parameters
    ----------
    library : iterable of Effect
        Effects of a layer, one at most with that slot.
    effects : NamedTuple
        Parameters by name of effect.

    Returns
    -------
    FedVolume
        The volume and its feed; zeros where there is none.

    Examples
    --------
    >>> class Line(NamedTuple):
    ...     volume: float = 0.0
    >>> line = Effect("line", Line, "V", "chosen", "", "", volume=lambda parameters: FedVolume(parameters.volume, 1e-5))
    >>> class Effects(NamedTuple):
    ...     line: Line = Line()
    >>> volume_of([line], Effects(Line(volume=1e-6)))
    FedVolume(volume=1e-06, feed_area=1e-05)
    """
    for effect in library:
        values = getattr(effects, effect.name)
        if effect.volume and effect.is_on(values):
            return FedVolume(*effect.volume(values))
    return FedVolume(0.0, 0.0)


def unserved(library: Iterable[Effect], effects: Any, marched: Mapping[str, type], served: Set[str]) -> Iterator[str]:
    """Find the effects of a library that would be ignored: nothing that is computed knows them.

    Parameters
    ----------
    library : iterable of Effect
        Effects of a layer.
    effects : NamedTuple
        Parameters by name of effect.
    marched : mapping of str to type
        Parameter class by name of effect, of those that the marches are compiled for, see `acting`.
    served : set of str
        Slots that are looked at for this library.

    Yields
    ------
    str
        Name of an effect that the machine has no place for; or that is on, without a slot, in one that is not
        served, or not among those marched; or that adds a second gas volume.

    Examples
    --------
    >>> class Drag(NamedTuple):
    ...     factor: float = 0.0
    >>> @law.for_type(Drag)
    ... def add_drag(effect, state, balance):
    ...     balance[0] -= effect.factor * state.speed
    >>> drag = Effect("drag", Drag, "F = -k v", "chosen", "a slower stroke", "strokes at two speeds")
    >>> class Effects(NamedTuple):
    ...     drag: Drag = Drag()
    >>> on = Effects(Drag(factor=2.0))
    >>> list(unserved([drag], on, {}, {"law"})), list(unserved([drag], on, {"drag": Drag}, {"law"}))
    (['drag'], [])
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


def adjusted(library: Iterable[Effect], effects: Any, machine: Any, tables: Any) -> tuple[Any, Any]:
    """Return a machine after every `adjust` of a library that is on.

    Parameters
    ----------
    library : iterable of Effect
        Effects of a layer.
    effects : NamedTuple
        Parameters by name of effect.
    machine, tables : NamedTuple
        Numbers and arrays, as the kernels see them.

    Returns
    -------
    machine, tables : NamedTuple
        Those with other parameters; the very ones given where no effect is on.

    Examples
    --------
    >>> class Bore(NamedTuple):
    ...     error: float = 0.0
    >>> class Cylinder(NamedTuple):
    ...     bore: float = 0.085
    >>> def adjust(parameters, machine, tables):
    ...     return machine._replace(bore=machine.bore + parameters.error), tables
    >>> bore = Effect("bore", Bore, "D + e", "chosen", "", "", adjust=adjust)
    >>> class Effects(NamedTuple):
    ...     bore: Bore = Bore()
    >>> adjusted([bore], Effects(Bore(error=0.04)), Cylinder(), None)
    (Cylinder(bore=0.125), None)
    """
    for effect in library:
        values = getattr(effects, effect.name)
        if effect.adjust and effect.is_on(values):
            machine, tables = effect.adjust(values, machine, tables)
    return machine, tables


def sensed(library: Iterable[Effect], effects: Any, reading: Any) -> Any:
    """Return a reading after every `sensor` of a library that is on.

    Parameters
    ----------
    library : iterable of Effect
        Effects of a layer.
    effects : NamedTuple
        Parameters by name of effect.
    reading : apesim.reading.Reading
        What exact sensors show.

    Returns
    -------
    apesim.reading.Reading
        What the sensors show; the very one given where no effect is on.

    Examples
    --------
    >>> from apesim.reading import Reading
    >>> class Late(NamedTuple):
    ...     time: float = 0.0
    >>> def sensor(parameters, reading):
    ...     return reading._replace(start=reading.start - parameters.time)
    >>> late = Effect("late", Late, "t - e", "chosen", "", "", sensor=sensor)
    >>> class Effects(NamedTuple):
    ...     late: Late = Late()
    >>> sensed([late], Effects(Late(time=0.5)), Reading(at=dict, start=1.0)).start
    0.5
    """
    for effect in library:
        values = getattr(effects, effect.name)
        if effect.sensor and effect.is_on(values):
            reading = effect.sensor(values, reading)
    return reading


def add_laws(effects: tuple[Any, ...], state: Any, balance: np.ndarray) -> None:
    """Let every effect of a tuple add to the balances.

    Parameters
    ----------
    effects : tuple of NamedTuple
        Parameters of the effects.
    state : NamedTuple
        State of the machine, in SI.
    balance : (n,) array
        Balances and branches of the layer, in SI; added to.

    Examples
    --------
    >>> class Drag(NamedTuple):
    ...     factor: float = 0.0
    >>> @law.for_type(Drag)
    ... def add_drag(effect, state, balance):
    ...     balance[0] -= effect.factor * state.speed
    >>> class State(NamedTuple):
    ...     speed: float
    >>> balance = np.zeros(1)
    >>> add_laws((Drag(factor=2.0), Drag(factor=1.0)), State(speed=3.0), balance)
    >>> balance.tolist()
    [-9.0]
    """
    for effect in effects:
        law(effect, state, balance)


# Numba compares the parameters of an overload with those of its body, annotations and all: both have none.
@overload(add_laws)
def _add_laws(effects, state, balance):
    if len(effects) == 0:
        return lambda effects, state, balance: None

    def add(effects, state, balance):
        law(effects[0], state, balance)
        add_laws(effects[1:], state, balance)

    return add


@kernel
def note_branch(balance: np.ndarray, index: int, branch: int) -> None:
    """Note on which branch of its law an effect is, where it has several.

    The number in the balance has a digit to the base 7 for each effect. Where it changes, the march ends a step.

    Parameters
    ----------
    balance : (n,) array
        Balances and branches of the layer; changed.
    index : int
        Element that notes branches.
    branch : int
        Branch, -3 to 3.

    Examples
    --------
    >>> balance = np.zeros(1)
    >>> note_branch(balance, 0, 1)
    >>> note_branch(balance, 0, -1)
    >>> balance.tolist()
    [6.0]
    """
    balance[index] = 7.0 * balance[index] + branch


def restitution(effects: tuple[Any, ...], speed: float) -> float:
    """Return the largest restitution that any effect of a tuple gives a stop.

    Parameters
    ----------
    effects : tuple of NamedTuple
        Parameters of the effects.
    speed : float
        Speed of the contact without sign [m/s].

    Returns
    -------
    float
        Speed after over speed before the contact; 0 without effects.

    Examples
    --------
    >>> class Soft(NamedTuple):
    ...     share: float = 0.0
    >>> @contact.for_type(Soft)
    ... def restitution_of_soft(effect, speed):
    ...     return effect.share
    >>> restitution((Soft(share=0.3), Soft(share=0.1)), 2.0), restitution((), 2.0)
    (0.3, 0.0)
    """
    return max([contact(effect, speed) for effect in effects], default=0.0)


@overload(restitution)
def _restitution(effects, speed):
    if len(effects) == 0:
        return lambda effects, speed: 0.0

    def largest(effects, speed):
        return max(contact(effects[0], speed), restitution(effects[1:], speed))

    return largest
