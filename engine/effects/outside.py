"""Effects from outside: files of a user, each with an effect like those of the library.

Such a file is code. It runs only where a user has named it or has installed the package that it is in: nothing here
takes one from an archive, a measured folder or the network.
"""

import ast
import hashlib
import importlib.util
import re
import sys
from importlib.machinery import SourceFileLoader
from importlib.metadata import EntryPoint, entry_points
from math import isfinite
from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from apesim.effect import Effect
from apesim.engine.effects import ALL_EFFECTS, ENGINE_SLOTS, VALVE_SLOTS
from apesim.quantities import Choice, Fault, InputError, InvalidValue, Quantity, quoted
from apesim.quantities.files import text_of
from apesim.quantities.trees import faults, fields

GROUP = "apesim.effects"
"""Group of entry points by which an installed package offers effects."""
PACKAGE = "apesim_effects"
"""Package that the files stand in once they are loaded; no folder has it."""
SLOTS = {"valve": VALVE_SLOTS, "engine": ENGINE_SLOTS}
"""Slots that a layer has room for."""
FILES_KEY = "files"
"""Key of the machine file's section ``effects`` that names files; no effect can be called so."""
MAX_NAME = 60
"""Characters of an effect's name: more would not fit into a column of a table."""
KNOWN_MODULES = {"apesim", "numba", "numpy", "scipy", *sys.stdlib_module_names}
"""Modules that a file may import. What it takes from others is compiled in, and an edit there would go unseen."""
FORM = 'EFFECT = Effect("my_effect", MyParameters, equation=..., source=..., layer="valve")'


class OutsideEffect(NamedTuple):
    """An effect from outside, and the file that it stands in."""

    effect: Effect
    path: Path
    """Absolute."""
    sha256: str
    """Hash of the file's content."""

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name


def load_effect(path: str | PathLike[str]) -> OutsideEffect:
    """Load a file with an effect: its code runs.

    It is a Python file that defines ``EFFECT``, see `apesim.effect.Effect`; where a file with the very content was
    loaded before, that one is returned. Raises InputError with one fault: the file cannot be read or run, or what it
    defines is no effect that the model has room for.
    """
    path = Path(path).absolute()
    try:
        content = text_of(path)
    except InvalidValue as wrong:
        raise InputError([Fault(str(path), "", wrong.wrong, "give the path of an effect's Python file")]) from None
    digest = hashlib.sha256(content.encode()).hexdigest()
    try:
        return OutsideEffect(_effect_of(_module(path, content, digest)), path, digest)
    except InvalidValue as wrong:
        raise InputError([Fault(str(path), "", wrong.wrong, wrong.right)]) from None


def load_again(path: Path, sha256: str) -> OutsideEffect:
    """The effect of a file in another process, loaded if need be.

    Raises InputError where the content of the file no longer has the hash that is wanted.

    >>> known = load_effect("docs/examples/data/tapered_bore.py")
    >>> load_again(known.path, known.sha256) == known
    True
    """
    if (name := _module_name(sha256)) in sys.modules:
        return OutsideEffect(sys.modules[name].EFFECT, path, sha256)
    found = load_effect(path)
    if found.sha256 != sha256:
        raise InputError([Fault(str(path), "", "was edited while it was in use", "start the work again")])
    return found


def loaded_effect(effect: Effect) -> OutsideEffect:
    """An effect that stands in a file, with that file.

    Of an effect that was loaded it is the one that is given, whatever has become of its file. Raises InputError where
    the effect stands in no file, so that no other process could find it, or not in one that could be loaded.

    >>> known = load_effect("docs/examples/data/tapered_bore.py")
    >>> loaded_effect(known.effect) == known
    True
    """
    module = sys.modules.get(getattr(effect.parameters, "__module__", ""))
    file = getattr(module, "__file__", None)
    if not file:
        raise InputError(
            [Fault("with_effects()", effect.name, "stands in no file", "write it into a file, and give its path")]
        )
    sha256 = getattr(module, "sha256", "")
    return load_again(Path(file), sha256) if sha256 else load_effect(file)


def installed_effects() -> list[OutsideEffect]:
    """Load what installed packages offer as entry points of the group ``apesim.effects``.

    They are sorted by the names of the entry points. Raises InputError where a package offers what cannot be loaded.
    """
    points = sorted(entry_points(group=GROUP), key=lambda point: (point.name, point.value))
    return [load_effect(_file_of(point)) for point in dict.fromkeys(points)]


def _file_of(point: EntryPoint) -> Path:
    """The file of the module that an entry point names."""
    package = point.dist.name if point.dist else "an installed package"
    where, right = f"entry point {point.name} of {package}", "mend the package or uninstall it"
    if (point.attr or "EFFECT") != "EFFECT":
        raise InputError([Fault(where, "", f"names {quoted(point.value)}", f"name the module: {point.module}")])
    try:
        spec = importlib.util.find_spec(point.module)
    except Exception as error:  # a parent package that cannot be imported raises anything
        raise InputError([Fault(where, "", f"{point.module} cannot be found: {error}", right)]) from None
    if spec is None or not spec.origin or not spec.origin.endswith(".py"):
        raise InputError([Fault(where, "", f"there is no Python file {point.module}", right)])
    return Path(spec.origin)


def _module_name(sha256: str) -> str:
    return f"{PACKAGE}.effect_{sha256[:16]}"


def _module(path: Path, content: str, digest: str) -> ModuleType:
    """The module of a file, under a name with the hash of its content: the compile cache finds its classes by it."""
    name = _module_name(digest)
    if name in sys.modules:
        sys.modules[name].__file__ = str(path)  # where it was loaded first, it may be gone
        return sys.modules[name]
    _refuse_imports(_tree(content))
    _ensure_package()
    spec = importlib.util.spec_from_file_location(name, path, loader=_Loader(name, str(path), content))
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    module.sha256 = digest  # type: ignore[attr-defined]
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise InvalidValue(f"{_line_of(error, path)}{type(error).__name__}: {error}", "mend the file") from None
    return module


class _Loader(SourceFileLoader):
    """Runs the very text that was hashed, and leaves no compiled file beside it."""

    def __init__(self, name: str, path: str, content: str) -> None:
        super().__init__(name, path)
        self.content = content

    def get_code(self, fullname: str) -> Any:
        return compile(self.content, self.path, "exec", dont_inherit=True)


def _ensure_package() -> None:
    if PACKAGE not in sys.modules:
        package = ModuleType(PACKAGE)
        package.__path__ = []
        sys.modules[PACKAGE] = package


def _tree(content: str) -> ast.Module:
    try:
        return ast.parse(content)
    except (SyntaxError, ValueError, RecursionError) as error:  # ValueError: a NUL byte
        number = getattr(error, "lineno", None)
        line = f"line {number}: " if number else ""
        raise InvalidValue(f"{line}no Python: {getattr(error, 'msg', error)}", "mend the file") from None


def _refuse_imports(tree: ast.Module) -> None:
    """Raise `InvalidValue` where a file imports what its hash does not know."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            names = ["." * node.level + (node.module or "")]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        for name in names:
            if name.split(".")[0] not in KNOWN_MODULES:
                right = "an effect is one file: write into it what it needs; it may import apesim, numpy, scipy, numba"
                raise InvalidValue(f"line {node.lineno}: imports {quoted(name)}", right)


def _line_of(error: BaseException, path: Path) -> str:
    """The last line of a file that an error came through."""
    trace, line = error.__traceback__, 0
    while trace:
        if trace.tb_frame.f_code.co_filename == str(path):
            line = trace.tb_lineno
        trace = trace.tb_next
    return f"line {line}: " if line else ""


def _effect_of(module: ModuleType) -> Effect:
    """The effect that a module defines, checked; raises `InvalidValue`."""
    effect = getattr(module, "EFFECT", None)
    if not isinstance(effect, Effect):
        raise InvalidValue(
            "defines no EFFECT" if effect is None else "its EFFECT is no apesim.effect.Effect", f"write {FORM}"
        )
    for fault in (_name_fault, _layer_fault, _parameters_fault, _slots_fault):
        if found := fault(effect, module):
            raise InvalidValue(f"EFFECT: {found[0]}", found[1])
    return effect


def _name_fault(effect: Effect, module: ModuleType) -> tuple[str, str] | None:
    name = effect.name
    form = "letters a-z, digits and _, such as sticky_piston"
    if not isinstance(name, str) or not re.fullmatch(rf"[a-z][a-z0-9_]{{1,{MAX_NAME - 1}}}", name):
        return f"{quoted(name)} is no name for an effect", form
    if name == FILES_KEY or name in {own.name for own in ALL_EFFECTS}:
        return f"{quoted(name)} is the name of one of ours", "give it another name"
    for key in ("equation", "source", "seen_in", "isolated_by"):
        if not isinstance(getattr(effect, key), str):
            return f"its {key} is no text", f'write {key}="..."'
    if effect.tabulated:
        return "it is a table", "leave tabulated out: an effect from outside is a law"
    return None


def _layer_fault(effect: Effect, module: ModuleType) -> tuple[str, str] | None:
    if effect.layer not in SLOTS:
        wrong = f"{quoted(effect.layer)} is no layer" if effect.layer else "says no layer"
        return wrong, 'give layer="valve" or layer="engine": whose balances and parameters it acts on'
    return None


def _parameters_fault(effect: Effect, module: ModuleType) -> tuple[str, str] | None:
    cls = effect.parameters
    form = 'class MyParameters(NamedTuple): force: Annotated[float, Quantity("N", 0, 10, "source")] = 0.0'
    if not (isinstance(cls, type) and issubclass(cls, tuple) and hasattr(cls, "_fields")):
        return "its parameters are no NamedTuple", f"write {form}"
    if getattr(module, cls.__name__, None) is not cls or cls.__module__ != module.__name__:
        return f"{cls.__name__} is not defined in this file by that name", "define it at the top level of the file"

    # What each parameter declares: a machine file, its checks and its printed text are made from that.
    try:
        declared = fields(cls)
    except Exception as error:  # an annotation can be anything
        text = str(error) if isinstance(error, TypeError) else f"{cls.__name__}: {error}"
        return f"{text.partition(' needs ')[0]} has no declared unit, range and default", f"write {form}"
    if not declared:
        return f"{cls.__name__} has no parameter", f"write {form}"
    for key, field in declared.items():
        if key.startswith("_") or not isinstance(field, Quantity | Choice):
            return f"{cls.__name__}.{key} is no number with a unit and a range", f"write {form}"
        try:
            field.check(cls._field_defaults[key])  # type: ignore[attr-defined]
        except InvalidValue as wrong:
            return f"the default of {cls.__name__}.{key}: {wrong.wrong}", wrong.right

    # The strengths, which are tried halfway to the end of their range: it needs two ends.
    strengths = effect.strengths or cls._fields[:1]  # type: ignore[attr-defined]
    for key in strengths:
        field = declared.get(key)
        if not isinstance(field, Quantity) or not all(map(isfinite, field.ends)) or field.ends[0] >= field.ends[1]:
            return f"its strength {quoted(key)} is no parameter with a range that has two ends", f"write {form}"

    # The defaults together: what is on by default would act in every machine that does not name it.
    if effect.is_on(cls()):
        return "it is on by default", f"give the strength the default {effect.off!r}, as off says"
    if found := next(faults(cls()), None):
        return f"the default of {cls.__name__}.{found[0]}: {found[1]}", found[2]
    return None


def _slots_fault(effect: Effect, module: ModuleType) -> tuple[str, str] | None:
    for slot in ("adjust", "volume", "sensor"):
        if getattr(effect, slot) is not None and not callable(getattr(effect, slot)):
            return f"its {slot} is no function", f"give {slot}=function"
    room = SLOTS[effect.layer]
    if strange := sorted(set(effect.slots) - room):
        return f"the {effect.layer} has no room for a {strange[0]}", f"it has for {', '.join(sorted(room))}"
    if not effect.slots:
        right = "register a kernel with @law.for_type(MyParameters), or give adjust=, volume= or sensor="
        return "it fills no slot and would do nothing", right
    return None


def refuse_twins(effects: tuple[OutsideEffect, ...]) -> None:
    """Refuse two files with effects of one name: raises InputError that names both; the very same file is no other."""
    seen: dict[str, OutsideEffect] = {}
    for one in effects:
        other = seen.setdefault(one.name, one)
        if other.sha256 != one.sha256:
            wrong = f"EFFECT: {quoted(one.name)} is the name of the effect in {other.path}, too"
            raise InputError([Fault(str(one.path), "", wrong, "rename one of them, or leave one file out")])
