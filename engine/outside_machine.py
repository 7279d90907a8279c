"""Machines with effects from outside: a class of machine for each set of files, and how a machine file names them.

The class of such a machine has a section ``effects`` with theirs behind ours. The types that its marches are compiled
for stand in a module whose name holds the hash of the files' content: an edited file makes other types, and what was
compiled for the old one is not taken for it. Pickled, a machine says which files it needs; who reads it loads
them again, and refuses a file that was edited meanwhile.
"""

import hashlib
import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from os import PathLike
from os import path as paths
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from apesim.effect import Effect, Library, acting
from apesim.engine.effect_trial import strong, try_effect
from apesim.engine.effects import ALL_EFFECTS, ENGINE_LIBRARY, Effects
from apesim.engine.effects.outside import (
    FILES_KEY,
    PACKAGE,
    OutsideEffect,
    installed_effects,
    load_again,
    load_effect,
    loaded_effect,
    refuse_twins,
)
from apesim.engine.machine import Machine
from apesim.quantities import Fault, InputError, quoted
from apesim.quantities.settings import COMMAND_LINE, load, toml_of
from apesim.valve.effects import VALVE_LIBRARY

SETTING = f"effects.{FILES_KEY}"
"""Key of a setting that names one file more; its path starts in the working directory."""
RIGHT = 'write files = ["my_effect.py"], paths from the folder of the machine file'
LAYERS = {"valve": VALVE_LIBRARY, "engine": ENGINE_LIBRARY}


def load_machine(path: str | PathLike[str] | None = None, assignments: Iterable[str] = ()) -> Machine:
    """The machine of a machine file and of settings, with the effects from outside that they name.

    Without a file, the defaults hold. Its ``[effects] files`` are loaded: their code runs; ``effects.files=PATH`` in
    `assignments`, see `apesim.quantities.settings.load`, names one file more. What installed packages offer is there,
    too; without effects from outside the machine is of the class `Machine` itself. Raises InputError with every fault.
    """
    data = {} if path is None else toml_of(path)
    rest, named = [], []
    for assignment in assignments:
        key, equals, value = (part.strip() for part in assignment.partition("="))
        if key == SETTING and equals:
            named.append(value.strip("\"'"))
        else:
            rest.append(assignment)
    found, all_faults = installed_effects(), []
    for fault, one in (*_of_file(data, path), *_of_settings(named)):
        all_faults += fault
        found += one
    if all_faults:
        raise InputError(all_faults)
    return load(machine_class(found), path, rest, data)


def _of_settings(named: Sequence[str]) -> Iterator[tuple[list, list]]:
    for text in named:
        if text:
            yield _tried(load_effect, text)
        else:
            yield [Fault(COMMAND_LINE, SETTING, "names no file", "give the path of an effect's Python file")], []


def _of_file(data: dict, path: str | PathLike[str] | None) -> Iterator[tuple[list, list]]:
    """Faults and effects of the files that parsed TOML names; what names them is taken out of it."""
    section = data.get("effects")
    if not isinstance(section, dict) or FILES_KEY not in section:
        return
    files, folder = section.pop(FILES_KEY), Path(path or ".").absolute().parent
    if not isinstance(files, list):
        yield [Fault(str(path), SETTING, f"{quoted(files)} is no list", RIGHT)], []
        return
    for entry in files:
        given = {"file": entry} if isinstance(entry, str) else entry
        is_good = isinstance(given, dict) and given.get("file") and set(given) <= {"effect", *OutsideFile._fields}
        if not is_good or not all(isinstance(text, str) for text in given.values()):
            yield [Fault(str(path), SETTING, f"{quoted(entry)} is no path", RIGHT)], []
            continue
        faults, found = _tried(load_effect, folder / given["file"])
        if found and given.get("sha256", found[0].sha256) != found[0].sha256:
            wrong = f"{quoted(given['file'])} is another file than the one with the sha256 that stands here"
            faults = [Fault(str(path), SETTING, wrong, "give that file, or delete sha256 to take this one")]
        yield faults, found


def _tried(load_one: Any, *arguments: Any) -> tuple[list, list]:
    try:
        return [], [load_one(*arguments)]
    except InputError as error:
        return error.faults, []


class OutsideFile(NamedTuple):
    """How a file is named again."""

    file: str
    sha256: str


def outside_effects_of(machine: Machine) -> tuple[OutsideEffect, ...]:
    """The effects from outside that a machine may have on; none where it is of the class `Machine` itself."""
    return getattr(machine, "outside_effects", ())


def switched_on(machine: Machine, one: OutsideEffect) -> Machine:
    """A machine with one of its effects from outside on, at half of its range: to compile what it needs.

    >>> machine = Machine().with_effects("docs/examples/data/tapered_bore.py")
    >>> switched_on(machine, machine.outside_effects[0]).effects.tapered_bore
    TaperedBore(friction=100.0)
    """
    return machine._replace(effects=machine.effects._replace(**{one.name: strong(one.effect)}))


def with_effects(machine: Machine, *given: Effect | str | PathLike[str]) -> Machine:
    """A machine that has effects from outside besides its own, all of them off.

    `given` are files, or effects that stand in files: their code runs. The machine is of another class, with the
    parameters of the effects in its section ``effects``. Raises InputError as
    `apesim.engine.effects.outside.load_effect` does, and where an effect stands in no file, so that no other process
    could find it.
    """
    found = [loaded_effect(one) if isinstance(one, Effect) else load_effect(one) for one in given]
    cls = machine_class([*outside_effects_of(machine), *found])
    effects = type(cls().effects)(**machine.effects._asdict())
    return cls(**machine._asdict() | {"effects": effects})


def machine_class(outside: Iterable[OutsideEffect]) -> type[Machine]:
    """The class of machines with effects from outside; `Machine` itself where there are none.

    A file that is there twice counts once. Raises InputError where two files have effects of one name, or an effect
    fails its trial, see `apesim.engine.effect_trial`.
    """
    given = tuple({one.sha256: one for one in outside}.values())
    if not given:
        return Machine
    refuse_twins(given)
    key = tuple((one.path, one.sha256) for one in given)
    if key not in _classes:
        for one in given:
            try_effect(one)
        _classes[key] = _machine_class(given)
    return _classes[key]


_classes: dict[tuple, type[Machine]] = {}
"""Classes of machines by the paths and hashes of their files."""


def _machine_class(given: tuple[OutsideEffect, ...]) -> type[Machine]:
    libraries = _libraries([one.effect for one in given], [one.sha256 for one in given])
    effects = _effects_class(given, libraries)
    machine = _class_with(effects)
    for cls in (machine, effects):
        cls.outside_effects = given  # type: ignore[attr-defined,union-attr]
    machine.__reduce__ = _machine_reduced  # type: ignore[method-assign,assignment]
    effects.__reduce__ = _effects_reduced
    for one in given:
        one.effect.parameters.__reduce__ = _parameters_reduced  # type: ignore[method-assign,assignment]
        one.effect.parameters.outside_effect = one  # type: ignore[attr-defined]
    return machine


def _libraries(outside: list[Effect], hashes: list[str]) -> dict[str, Library]:
    """The library of each layer with effects from outside.

    The types of the marches stand in a module that is named by the hash of the files' content alone: the compile cache
    finds them by it, wherever the files stand.
    """
    outside_hash = hashlib.sha256(" ".join(hashes).encode()).hexdigest()[:16]
    module = sys.modules.setdefault(f"{PACKAGE}.laws_{outside_hash}", ModuleType(f"{PACKAGE}.laws_{outside_hash}"))
    libraries = {}
    for layer, own in LAYERS.items():
        effects = own.effects + tuple(effect for effect in outside if effect.layer == layer)
        marches = own.marches[1:]
        if any(effect.is_from_outside and effect.is_marched for effect in effects):
            kinds = {f"{layer.title()}Laws": False, f"{layer.title()}Tables": True}
            for name, tables in kinds.items():
                if not hasattr(module, name):
                    kind = acting(name, module.__name__, effects, tables=tables, outside=True)
                    kind.outside_hash = outside_hash  # type: ignore[attr-defined]
                    setattr(module, name, kind)
            marches = tuple(getattr(module, name) for name in kinds)
        libraries[layer] = Library(effects, own.marches + marches)
    return libraries


def _effects_class(given: tuple[OutsideEffect, ...], libraries: dict[str, Library]) -> Any:
    """The section ``effects`` with those from outside."""
    own = [(effect.name, effect.parameters) for effect in ALL_EFFECTS]
    cls: Any = NamedTuple("Effects", [*own, *((one.name, one.effect.parameters) for one in given)])  # type: ignore
    cls.__doc__ = Effects.__doc__
    cls.__new__.__defaults__ = tuple(parameters() for parameters in cls.__annotations__.values())
    theirs = {one.name: one.effect.strengths or one.effect.parameters._fields[:1] for one in given}  # type: ignore
    cls.due = Effects.due | theirs  # type: ignore[attr-defined]
    cls.libraries = libraries  # type: ignore[attr-defined]
    cls.library = libraries["valve"].effects + libraries["engine"].effects  # type: ignore[attr-defined]
    cls.stated = _stated  # type: ignore[attr-defined]
    return cls


def _class_with(effects: Any) -> type[Machine]:
    """The class of a machine with another section ``effects``."""

    class Extended(Machine):
        __slots__ = ()
        _field_defaults = Machine._field_defaults | {"effects": effects()}

        def __new__(cls, *sections: Any, **named: Any) -> Any:
            given = dict(zip(cls._fields, sections, strict=False)) | named
            return super().__new__(cls, **({"effects": effects()} | given))

        def faults(self) -> Iterator[tuple[str, str, str]]:
            """Faults that no single section shows."""
            crowded = dict(_crowded(self.effects))
            for name, other in crowded.items():
                wrong = f"is a second gas volume beside {other}"
                yield f"effects.{name}", wrong, "switch one of them off: a layer has room for one"
            for fault in super().faults():
                if fault[0].removeprefix("effects.") not in crowded:
                    yield fault

    Extended.__name__ = Extended.__qualname__ = "Machine"
    Extended.__doc__ = Machine.__doc__
    Extended.__annotations__ = {"effects": effects}
    return Extended


def _crowded(effects: Any) -> Iterator[tuple[str, str]]:
    """Names of effects that are on and add a gas volume where there is one already, each with that one's name."""
    for library in effects.libraries.values():
        on = [each.name for each in library.effects if each.volume and each.is_on(getattr(effects, each.name))]
        yield from ((name, on[0]) for name in on[1:])


def _stated(effects: Any, folder: str | Path | None) -> list[str]:
    """Lines of a machine file that name the files of effects from outside.

    The machine file is to stand in `folder`; None: what is written is a record, with the name of each file and the hash
    of its content.
    """
    outside: tuple[OutsideEffect, ...] = effects.outside_effects
    if folder is None:
        rows = [
            f'    {{ effect = "{one.name}", file = {_string(one.path.name)}, sha256 = "{one.sha256}" }},'
            for one in outside
        ]
        return [f"{FILES_KEY} = [", *rows, "]"]
    return [f"{FILES_KEY} = [{', '.join(_string(_path_from(folder, one.path)) for one in outside)}]"]


def _path_from(folder: str | PathLike[str], path: Path) -> str:
    """A path as a machine file in a folder would name it: relative within the folder, else absolute."""
    folder = Path(folder).absolute()
    return paths.relpath(path, folder) if path.is_relative_to(folder) else str(path)


def _string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)  # TOML escapes as JSON does


def _machine_reduced(machine: Any) -> tuple:
    """How a machine is pickled: its class is that with the files of its section ``effects``."""
    return _restored_machine, tuple(machine)


def _effects_reduced(effects: Any) -> tuple:
    """How a section ``effects`` is pickled: with the files that define its class."""
    outside: tuple[OutsideEffect, ...] = effects.outside_effects
    own = len(effects) - len(outside)
    files = tuple((str(one.path), one.sha256) for one in outside)
    return _restored_effects, (files, effects[:own], tuple(map(tuple, effects[own:])))


def _parameters_reduced(values: Any) -> tuple:
    one: OutsideEffect = values.outside_effect
    return _restored_parameters, (str(one.path), one.sha256, tuple(values))


def _restored_machine(*sections: Any) -> Machine:
    """A machine from a pickle, of the class with the effects of its section ``effects``."""
    effects: Any = sections[Machine._fields.index("effects")]
    return machine_class(effects.outside_effects)(*sections)


def _restored_effects(files: tuple, own: tuple, outside: tuple) -> Any:
    """The section ``effects`` of a machine from a pickle; the files are loaded if they are not yet.

    `files` are pairs of path and hash, `own` the parameters of our effects, `outside` the values of the parameters of
    those from outside. Raises InputError where a file is not there any more, or was edited.
    """
    found = [load_again(Path(path), sha256) for path, sha256 in files]
    cls = type(machine_class(found)().effects)
    pairs = zip(found, outside, strict=True)
    return cls(*own, *(one.effect.parameters._make(values) for one, values in pairs))  # type: ignore[attr-defined]


def _restored_parameters(path: str, sha256: str, values: tuple) -> Any:
    """Parameters of an effect from outside from a pickle, see `_restored_effects`."""
    return load_again(Path(path), sha256).effect.parameters._make(values)  # type: ignore[attr-defined]
