"""Machine: everything that a machine file can say."""

from collections.abc import Iterable, Iterator
from html import escape
from math import pi, sqrt
from os import PathLike
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Protocol, Self, TypeVar, overload

from apesim.air import Air, Ambient
from apesim.effect import Effect
from apesim.engine.command import Command
from apesim.engine.cylinder import MAX_CYLINDERS, Engine
from apesim.engine.effects import Effects, unserved_effects
from apesim.engine.first_keys import select_first_keys
from apesim.engine.proportions import Unscaled, find_unscaled
from apesim.engine.second_stage import InterReceiver, SecondStage
from apesim.engine.shaft import Load, Shaft
from apesim.engine.stated_uncertainties import KnownTo, find_odd_shares
from apesim.quantities import Fault, InputError, quoted
from apesim.quantities.overrides import Overridden, Overrides
from apesim.quantities.settings import differences, dumps, find_ignored_keys, overruled, replaced
from apesim.quantities.trees import contents_of, with_value
from apesim.quantities.trees import faults as find_faults
from apesim.quantities.uncertainties import Uncertainty
from apesim.valve.groove import Groove
from apesim.valve.piston import Valve
from apesim.valve.rig import Rig
from apesim.valve.supply import Supply


def _faults_of_paths(where: str, key: str, paths: Iterable[Any]) -> list[Fault]:
    """Faults of what is given for paths and is none: a number would be taken for an open file."""
    strange = [path for path in paths if not isinstance(path, str | PathLike)]
    return [Fault(where, key, f"{quoted(path)} is no path", "give the path of a file") for path in strange]


def groove_faults(valve: Valve, groove: Groove, section: str) -> Iterator[tuple[str, str, str]]:
    """Find what is wrong with a groove, named by its `section`, in the piston of a valve: key, wrong, right."""
    if groove.lap >= valve.stroke:
        yield f"{section}.lap", "the groove never opens", f"less than the valve's stroke, {valve.stroke * 1e3:g} mm"
    ports, round_piston = groove.ports, sqrt(4.0 * pi * valve.piston_area)
    if groove.has_ports and ports.number * ports.diameter > round_piston:
        room = f"number times diameter at most {round_piston * 1e3:.4g} mm, the way round the valve's piston"
        yield f"{section}.ports.number", f"{ports.number:g} ports of {ports.diameter * 1e3:g} mm overlap", room


MAX_DIFFERENCES = 8
"""Keys that a short text of a machine names: it stays below a dozen lines."""
MAX_ROWS = 30
"""Keys that a notebook shows of a machine: below 5 kB."""


class OwnKeys(NamedTuple):
    """Sections of which a cylinder may have keys of its own."""

    valve: Valve = Valve()
    groove: Groove = Groove()
    command: Command = Command()


class Sections(NamedTuple):
    """Sections of a machine file, in the order in which it is printed."""

    air: Air = Air()
    ambient: Ambient = Ambient()
    supply: Supply = Supply()
    valve: Valve = Valve()
    groove: Groove = Groove()
    engine: Engine = Engine()
    command: Command = Command()
    shaft: Shaft = Shaft()
    load: Load = Load()
    stage_2: SecondStage = SecondStage()
    inter_receiver: InterReceiver = InterReceiver()
    rig: Rig = Rig()
    effects: Effects = Effects()
    cylinder: Annotated[
        tuple[Overridden, ...],
        Overrides(
            OwnKeys,
            "cylinder",
            'valve.solenoid.dead_time = "1.7 ms"',
            MAX_CYLINDERS,
            "A table for each cylinder, in order: keys of valve, groove and command that are its own.",
        ),
    ] = ()
    known_to: Annotated[
        tuple[tuple[str, Uncertainty], ...],
        KnownTo("How far numbers are known, for gap explain and gap isolability; nothing that is simulated reads it."),
    ] = ()


AnyMachine = TypeVar("AnyMachine", bound="Machine")
ReadMachine = TypeVar("ReadMachine", bound="Machine", covariant=True)


class _Reader(Protocol[ReadMachine]):
    """Type of `Machine.load`."""

    def __call__(self, path: str | PathLike[str] | None = None, settings: Iterable[str] = ()) -> ReadMachine:
        """Read a machine."""
        ...


class _LoadOrReader:
    """Attribute ``load``: of a machine its section of that name, of the class what reads a machine file.

    Both names are promised to users, and a field of a named tuple leaves no room for a method of its name.
    """

    @overload
    def __get__(self, machine: None, cls: type[AnyMachine]) -> _Reader[AnyMachine]: ...

    @overload
    def __get__(self, machine: Sections, cls: type[Any]) -> Load: ...

    def __get__(self, machine: Any, cls: type[Any]) -> Any:
        return cls._load if machine is None else machine[LOAD]


LOAD = Sections._fields.index("load")
"""Place of the section ``load``."""


class Machine(Sections):
    """Air-powered engine and its electro-pneumatic valve; "the paper" is the EPV paper (doi 10.1631/jzus.A0820373)."""

    __slots__ = ()
    load = _LoadOrReader()  # type: ignore[assignment]

    @classmethod
    def _load(cls, path: str | PathLike[str] | None = None, settings: Iterable[str] = ()) -> Self:
        """Read a machine from a machine file and settings like those of the command line.

        Parameters
        ----------
        path : path, optional
            Machine file (TOML); the default machine if left out.
        settings : iterable of str
            ``KEY=VALUE``, e.g. ``engine.bore=90 mm``; the later one wins. ``effects.files=PATH`` names a file more with
            an effect from outside, beside those of the machine file. Their code runs.

        Returns
        -------
        Machine
            With effects from outside of a class of its own, see `with_effects`.

        Raises
        ------
        InputError
            With every fault.

        Examples
        --------
        >>> machine = Machine.load(settings=["engine.bore=90 mm"])
        >>> machine.engine.bore
        0.09
        """
        from apesim.engine.outside_machine import load_machine

        faults = [] if path is None else _faults_of_paths("Machine.load()", "path", [path])
        settings = [settings] if isinstance(settings, str) or not isinstance(settings, Iterable) else list(settings)
        right = 'write texts KEY=VALUE, e.g. ["engine.bore=90 mm"]'
        strange = [text for text in settings if not isinstance(text, str)]
        faults += [Fault("Machine.load()", "settings", f"{quoted(text)} is no text", right) for text in strange]
        if faults:
            raise InputError(faults)
        return load_machine(path, settings)  # type: ignore[return-value]

    def with_(self, **values: Any) -> Self:
        """Make a machine that differs in some keys; it is refused for what a machine file would be refused for.

        Parameters
        ----------
        **values : str, tuple, float, int or array
            By the key of the machine file, with underscores for its dots (``engine_bore``) or as it is in a mapping
            (``**{"engine.bore": ...}``): a text with its unit, a number with its unit (``(90, "mm")``), or a number in
            SI, a pressure absolute. An angle has to have its unit.

        Returns
        -------
        Machine
            A new one; this one stays as it is.

        Raises
        ------
        InputError
            With every fault.

        Examples
        --------
        >>> machine = Machine().with_(engine_bore="90 mm", **{"supply.pressure": "0.8 MPa gauge"})
        >>> machine.engine.bore
        0.09
        >>> machine
        Machine that differs from the default one in
          supply.pressure = 0.8 MPa gauge
          engine.bore = 90 mm
        """
        return replaced(self, values, "Machine.with_()")

    def with_effects(self, *effects: Effect | str | PathLike[str]) -> "Machine":
        """Make a machine with effects from outside besides its own, all of them off.

        Parameters
        ----------
        *effects : apesim.effect.Effect or path
            Python files like those of the library, or effects that stand in such files. Their code runs.

        Returns
        -------
        Machine
            Of a class of its own, with the parameters of the effects in its section ``effects``.

        Raises
        ------
        InputError
            A file cannot be read or run, or what it defines is nothing that the model has room for.

        Examples
        --------
        >>> machine = Machine().with_effects("my_effect.py")  # doctest: +SKIP
        """
        from apesim.engine.outside_machine import with_effects

        paths = [effect for effect in effects if not isinstance(effect, Effect)]
        if faults := _faults_of_paths("Machine.with_effects()", "", paths):
            raise InputError(faults)
        return with_effects(self, *effects)

    def to_toml(self, keys: Literal["all", "first"] = "all") -> str:
        """Print the machine as a commented machine file of the working directory, which `load` reads back.

        Parameters
        ----------
        keys : {"all", "first"}
            Keys to print: all of them; or those that a user fills in first, and others that are not as by default.

        Returns
        -------
        str
            Text of the machine file.

        Raises
        ------
        InputError
            `keys` is another word.

        Examples
        --------
        >>> print(Machine().to_toml().splitlines()[0])
        # Air-powered engine and its electro-pneumatic valve; "the paper" is the EPV paper (doi
        >>> len(Machine().to_toml("first").splitlines()) < 50
        True
        """
        if keys not in ("all", "first"):
            wrong = f"{quoted(keys)} is no option"
            raise InputError([Fault("Machine.to_toml()", "keys", wrong, 'write "all" or "first"')])
        return dumps(self, Path.cwd(), keys=select_first_keys(self) if keys == "first" else None)

    def find_ignored_keys(self) -> dict[str, str]:
        """Find the keys that differ from the default machine's and have no effect, because of others.

        Returns
        -------
        dict of str to str
            What is used in its place, by key of the machine file.

        Examples
        --------
        >>> ports = Machine().with_(groove_geometry="ports", groove_ports_number=6)
        >>> ports.with_(groove_geometry="line").find_ignored_keys()
        {'groove.ports.number': 'groove.geometry is "line"'}
        """
        ignored = find_ignored_keys(self)
        for index, own in enumerate(self.cylinder):
            reasons = dict(overruled(self._with_own(own)))
            ignored |= {f"cylinder[{index + 1}].{key}": reasons[key] for key, _ in own if key in reasons}
        return ignored

    def machine_of_cylinder(self, index: int) -> Self:
        """Make the machine of one cylinder: with what its table ``[[cylinder]]`` has of its own, and no such tables.

        Parameters
        ----------
        index : int
            Which cylinder, from 0 on.

        Returns
        -------
        Machine
            A new one, with the number of cylinders and the phases of this one; this one stays as it is.

        Raises
        ------
        InputError
            The engine has no such cylinder.

        Examples
        --------
        >>> machine = Machine().with_(engine_cylinders=2, cylinder=[{}, {"valve.solenoid.dead_time": "1.7 ms"}])
        >>> [machine.machine_of_cylinder(index).valve.solenoid.dead_time for index in range(2)]
        [0.0015, 0.0017]
        """
        count = int(self.engine.cylinders)
        if index not in range(count):
            wrong, right = f"{quoted(index)} is no cylinder of {count}", f"give a whole number from 0 to {count - 1}"
            raise InputError([Fault("Machine.machine_of_cylinder()", "index", wrong, right)])
        return self._with_own(self.cylinder[index] if index < len(self.cylinder) else ())

    def _with_own(self, own: Overridden) -> Self:
        """The machine with other values for some keys, and without tables of cylinders."""
        machine = self._replace(cylinder=())
        for key, value in own:
            machine = with_value(machine, key, value)
        return machine

    def _faults_of_cylinders(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with cylinders that have keys of their own, beyond the machine's faults."""
        given, count = len(self.cylinder), int(self.engine.cylinders)
        if given > count:
            engine = f"{count} cylinder{'s' * (count > 1)}"
            yield (
                "cylinder",
                f"has {given} tables for {engine}",
                f"write at most {count}, or raise engine.cylinders",
            )
        of_all = set(find_faults(self._replace(cylinder=()))) if given else set()
        for index, own in enumerate(self.cylinder):
            for key, wrong, right in find_faults(self._with_own(own)) if own else ():
                if (key, wrong, right) not in of_all:
                    yield f"cylinder[{index + 1}].{key}", wrong, right

    def find_unscaled_keys(self) -> list[Unscaled]:
        """Find the numbers that are still the default machine's, though a dimension that they belong to is not.

        Returns
        -------
        list of apesim.engine.proportions.Unscaled
            Key, value, the changed keys, and the reason, for each number.

        Examples
        --------
        A valve of another stroke still has the mass of the default one:

        >>> key, value, changed, reason = Machine().with_(valve_stroke="6 mm").find_unscaled_keys()[0]
        >>> print(key, "=", value, "with a changed", *changed)
        valve.moving_mass = 0.1145 kg with a changed valve.stroke
        """
        return list(find_unscaled(self))

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, Machine) and contents_of(self) == contents_of(other))

    def __ne__(self, other: object) -> bool:
        return not self == other  # a tuple has its own

    def __hash__(self) -> int:
        return hash(contents_of(self))

    def __repr__(self) -> str:
        changes = [f"  {key} = {text}" for key, text in differences(self)]
        if not changes:
            return "Machine(), the default one"
        lines = changes if len(changes) <= MAX_DIFFERENCES else changes[: MAX_DIFFERENCES - 1]
        more = [f"  and {len(changes) - len(lines)} keys more, see to_toml()"] * (len(changes) > len(lines))
        return "\n".join(["Machine that differs from the default one in", *lines, *more])

    def _repr_html_(self) -> str:
        rows = [f"<tr><td>{escape(key)}</td><td>{escape(text)}</td></tr>" for key, text in differences(self)]
        if not rows:
            return "<div>Machine(), the default one</div>"
        left = len(rows) - MAX_ROWS
        more = f"<div>and {left} keys more, see to_toml()</div>" * (left > 0)
        caption = "<caption>Machine that differs from the default one in</caption>"
        return f"<table>{caption}<tbody>{''.join(rows[:MAX_ROWS])}</tbody></table>{more}"

    def overruled(self) -> Iterator[tuple[str, str]]:
        """Find the sections that are not used because of others.

        Yields
        ------
        section, reason : str
            Section of the machine file, and what is used in its place.

        Examples
        --------
        >>> list(Machine().overruled())
        [('inter_receiver', 'stage_2.bore is 0')]
        """
        if not self.stage_2.is_on:
            yield "inter_receiver", "stage_2.bore is 0"

    def faults(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the machine, beyond the faults of its single sections.

        Yields
        ------
        key, wrong, right : str
            Key of the machine file, what is wrong with it, and what would be right.

        Examples
        --------
        >>> list(Machine().faults())
        []
        >>> [key for key, wrong, right in Machine(groove=Groove(lap=20e-3)).faults()]
        ['groove.lap']
        """
        yield from groove_faults(self.valve, self.groove, "groove")
        yield from groove_faults(self.valve, self.stage_2.groove, "stage_2.groove") if self.stage_2.is_on else ()
        if self.stage_2.is_on and self.engine.cylinders > 1.0:
            wrong = f"is {self.engine.cylinders:g} beside a second stage"
            yield "engine.cylinders", wrong, "write 1: two stages have one cylinder each"
        yield from self._faults_of_cylinders()
        yield from find_odd_shares(self)
        for name in unserved_effects(self.effects):
            yield f"effects.{name}", "nothing that is computed knows it", "a file in valve/effects or engine/effects"


Machine.due = {"stage_2": ("bore",)}  # type: ignore[attr-defined]
