"""Kernels, the entries that Python calls, and functions that are chosen by type: how they are compiled.

A function chosen by type has a body for each type of its first argument. Only an entry is compiled to be called from
Python and kept in the cache, all its kernels in it (`apesim.linking`). Numba's disk cache notices an edit only in the
file a function stands in; an edited callee elsewhere would silently give the old answer. The cache folder is therefore
named by a hash of every source file that holds kernels, so that any edit opens a new, empty folder.
What is compiled for laws from outside these files has a folder within it, named by a hash of theirs.
"""

import contextlib
import functools
import hashlib
import importlib.util
import os
import platform
import shutil
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, Protocol, TypeVar, overload

import llvmlite.binding
import numba
import numpy
from numba.core import types
from numba.core.caching import FunctionCache
from numba.core.runtime import rtsys
from numba.core.typing.templates import AbstractTemplate, infer_global

from apesim.cache import cache_root, private_folder, temporary_folder, warn_of_temporary
from apesim.compiling import kind_of_march_types, note_compile_time, tell_of_compiling
from apesim.linking import jit

LAYERS = ("apesim", "apesim.valve", "apesim.engine")
UPPER_LAYERS = ("valve", "engine", "studies")
"""Folders that stand within that of `apesim` where it is installed, and beside it in a checkout."""
FOLDERS_KEPT = 4
"""Folders of compiled kernels that are kept, each of another version of the sources, the compiler or the processor."""
OUTSIDE_FOLDERS_KEPT = 16
"""Folders within it that are kept, each of other effects from outside: who tries several of them goes back to some."""
config: Any = numba.config
"""Options of Numba, which it sets from the environment."""
OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True}
Function = TypeVar("Function", bound=Callable[..., Any])
"""Type of a function that is compiled: a decorator leaves it as it is."""


def _sources() -> Iterator[tuple[str, Path]]:
    """Name and path of every source file that can hold kernels, in the order of the layers."""
    for layer in LAYERS:
        spec = importlib.util.find_spec(layer)
        assert spec is not None and spec.submodule_search_locations is not None
        folder = spec.submodule_search_locations[0]
        for path in sorted(Path(folder).rglob("*.py")):
            name = path.relative_to(folder).as_posix()
            if layer != "apesim" or name.split("/")[0] not in UPPER_LAYERS:
                yield f"{layer}/{name}", path


@functools.cache
def sources_hash() -> str:
    """Return the hash of all kernel sources, of the compiler and of the processor.

    Returns
    -------
    str
        16 hexadecimal digits.

    Examples
    --------
    >>> len(sources_hash())
    16
    """
    digest = hashlib.sha256()
    for name, path in _sources():
        digest.update(name.encode())
        digest.update(path.read_bytes())
    for part in (
        sys.version,
        numba.__version__,
        numpy.__version__,
        platform.machine(),
        llvmlite.binding.get_host_cpu_name(),
    ):
        digest.update(part.encode())
    return digest.hexdigest()[:16]


def _prune(keep: Path, pattern: str, kept: int) -> None:
    """Delete the folders beside one that were made or used longest ago, so that so many are kept."""
    others = [f for f in keep.parent.glob(pattern) if f != keep]
    others.sort(key=lambda f: f.stat().st_mtime, reverse=True)
    for old in others[kept - 1 :]:
        shutil.rmtree(old, ignore_errors=True)


@functools.cache
def cache_folder() -> Path:
    """Return the folder of the compiled kernels.

    They are pickles, which run code when they are read, so it is ours alone.

    Returns
    -------
    pathlib.Path
        A temporary one where none can be kept, see `apesim.cache.private_folder`.

    Examples
    --------
    >>> cache_folder().is_dir()
    True
    """
    name = f"kernels-{sources_hash()}"
    is_new = False
    with contextlib.suppress(RuntimeError, OSError):  # RuntimeError: the user has no home folder
        is_new = not (cache_root() / name).exists()
    folder = private_folder(name)
    if folder is None:
        folder = temporary_folder(name)
        warn_of_temporary()
    elif is_new:
        _prune(folder, "kernels-*", FOLDERS_KEPT)
    return folder


def outside_folder(outside_hash: str) -> Path:
    """Return the folder of what is compiled for laws from outside the layers' files.

    It stands within that of the compiled kernels, and is made where it is not there.

    Parameters
    ----------
    outside_hash : str
        Hash of the files that the laws stand in.

    Returns
    -------
    pathlib.Path
        The folder.

    Examples
    --------
    >>> outside_folder("0123abcd").relative_to(cache_folder()).as_posix()
    'outside-0123abcd'
    """
    folder = cache_folder() / f"outside-{outside_hash}"
    if folder.exists():
        os.utime(folder)  # the one that is unused for longest goes first
    else:
        folder.mkdir(mode=0o700, exist_ok=True)
        _prune(folder, "outside-*", OUTSIDE_FOLDERS_KEPT)
    return folder


def outside_hash_of(arguments: Iterable[types.Type]) -> str:
    """Return the hash of the files from outside the layers that the laws of a call stand in.

    Parameters
    ----------
    arguments : iterable of numba types
        Types of the call's arguments. A NamedTuple class among them, at any depth, that holds such laws has the hash
        as its attribute ``outside_hash``.

    Returns
    -------
    str
        The hash; "" where there are none.

    Examples
    --------
    >>> outside_hash_of([types.float64, types.UniTuple(types.float64, 2)])
    ''
    """
    for kind in arguments:
        if isinstance(kind, types.BaseTuple):
            members: Any = kind  # a tuple type is iterated over the types of its members
            outside_hash = getattr(getattr(kind, "instance_class", None), "outside_hash", "")
            if found := outside_hash or outside_hash_of(members):
                return found
    return ""


class _SelfHealingCache(FunctionCache):
    """A kernel's cache that compiles anew where a file of it is damaged.

    Numba's own would bring its whole registry up to date first, which takes half a second that compiled code does not
    need: only what allocates arrays is there before it.
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            rtsys.initialize(target_context)
            with self._guard_against_spurious_io_errors():
                return self._load_overload(sig, target_context)
        except Exception:  # a garbled pickle raises anything, a MemoryError too
            self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except Exception:
            self.flush()
            super().save_overload(sig, data)


class _EntryCache(_SelfHealingCache):
    """An entry's cache; what is compiled for laws from outside is kept apart. It tells and times what is compiled.

    An index that names a type which no file has brought into this process could not be read.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self._function = function
        self._apart: dict[str, FunctionCache] = {}
        self._begin = 0.0

    def _cache_for(self, sig: Any) -> Any:
        outside_hash = outside_hash_of(sig)
        if outside_hash and outside_hash not in self._apart:
            self._apart[outside_hash] = _cache_in(outside_folder(outside_hash), _SelfHealingCache, self._function)
        return self._apart.get(outside_hash, super())

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        loaded = self._cache_for(sig).load_overload(sig, target_context)
        if loaded is None:  # Numba compiles next, and saves what it has compiled
            tell_of_compiling(kind_of_march_types(sig))
            self._begin = time.perf_counter()
        return loaded

    def save_overload(self, sig: Any, data: Any) -> None:
        note_compile_time(kind_of_march_types(sig), time.perf_counter() - self._begin)
        self._cache_for(sig).save_overload(sig, data)

    def kept_kinds(self, codegen: Any) -> set[str]:
        """Kinds of march that are in the cache for a processor, without those that have an effect from outside."""
        try:
            index = self._cache_file._load_index()
        except Exception:  # a garbled pickle raises anything
            return set()
        now = self._index_key(None, codegen)[1:]
        kept = [key[0] for key, name in index.items() if key[1:] == now and self._has(name)]
        return {kind_of_march_types(sig) for sig in kept}

    def _has(self, name: str) -> bool:
        """Whether a file of compiled code is there."""
        return Path(self._cache_file._data_path(name)).exists()


def _cache_in(folder: Path, kind: type[FunctionCache], function: Callable[..., Any]) -> FunctionCache:
    """A cache of a function's compiled forms, of the given kind, in a folder."""
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        return kind(function)
    finally:
        config.CACHE_DIR = before


def _let_call(function: Callable[..., Any], body_for: Callable[[Any], Any]) -> None:
    """Let compiled code call a function of Python by the kernel that it has for the type of the first argument."""

    class Call(AbstractTemplate):
        key = function

        def generic(self, args: Any, kws: Any) -> Any:
            return types.Dispatcher(body_for(args[0])).get_call_type(self.context, args, kws)

        def get_impl_key(self, signature: Any) -> Any:
            return body_for(signature.args[0]).get_overload(signature.args)

    infer_global(function, types.Function(Call))


@overload
def kernel(function: Function, *, inline: bool = ...) -> Function: ...
@overload
def kernel(function: None = ..., *, inline: bool = ...) -> Callable[[Function], Function]: ...
def kernel(function: Callable[..., Any] | None = None, *, inline: bool = True) -> Any:
    """Let a pure function of floats, arrays and NamedTuples be compiled into the kernels that call it.

    Called from Python it stays the function it is: what unpacks a machine's parameters from Python takes as long to
    compile as a law. Without fast-math, so that compiled and plain Python (``NUMBA_DISABLE_JIT=1``) give the same
    bits. A kernel from outside may make arrays, as for `numpy.interp`; that costs time in each of its calls.

    Parameters
    ----------
    function : function
        Function that is decorated; None where ``inline`` is given.
    inline : bool
        Whether the function is laid into its callers. A law is: handing it the parameters would cost more than the
        law. The long functions that are called in several places are not.

    Returns
    -------
    function
        The same function, which kernels can call from now on; or the decorator, where only ``inline`` is given.

    Examples
    --------
    >>> @kernel
    ... def twice(x):
    ...     return 2.0 * x
    >>> twice(1.5)
    3.0
    """
    if function is None:
        return functools.partial(kernel, inline=inline)
    # Kernels of ours make no arrays, and count no references to those that they are given.
    counts = not function.__module__.startswith("apesim.")
    bare: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "forceinline": inline, "_nrt": counts}
    compiled = jit(function, **OPTIONS, **bare)
    function.compiled = compiled  # type: ignore[attr-defined]  # by_type finds it there
    _let_call(function, lambda first: compiled)
    return function


def entry(function: Callable[..., Any]) -> Any:
    """Compile a function that is called from Python, with all kernels that it calls, and keep it in the cache.

    Parameters
    ----------
    function : function
        Function that is decorated.

    Returns
    -------
    numba dispatcher
        Compiled function; the plain one where compilation is switched off.

    Examples
    --------
    >>> @kernel
    ... def twice(x):
    ...     return 2.0 * x
    >>> @entry
    ... def four_times(x):
    ...     return twice(twice(x))
    >>> four_times(1.5)
    6.0
    """
    options = OPTIONS | {"no_cfunc_wrapper": True}
    compiled = jit(function, **options)
    if not config.DISABLE_JIT:
        compiled._cache = _cache_in(cache_folder(), _EntryCache, function)
    return compiled


def compiled_for(compiled: Any, *arguments: Any) -> Callable[..., Any]:
    """Return what an entry was compiled to for arguments of these types, to be called with no other ones.

    Looking at the types of its arguments, a machine's among them, takes an entry longer than a march of a tenth of a
    millisecond does. What is returned does not look.

    Parameters
    ----------
    compiled : numba dispatcher
        Entry, see `entry`; compiled, or taken from the cache, where it is not so already.
    *arguments
        Arguments, for their types; the entry is not called.

    Returns
    -------
    function
        Compiled function; the plain one where compilation is switched off.

    Examples
    --------
    >>> @entry
    ... def third(x):
    ...     return x / 3.0
    >>> compiled_for(third, 1.0)(6.0)
    2.0
    """
    if config.DISABLE_JIT:
        return compiled  # type: ignore[no-any-return]  # the function itself
    return compiled.compile(tuple(map(numba.typeof, arguments)))  # type: ignore[no-any-return]  # numba has no types


def kept_kinds(compiled: Any) -> set[str]:
    """Return the kinds of march that the cache holds of an entry, ready to be loaded.

    Parameters
    ----------
    compiled : numba dispatcher
        Entry, see `entry`.

    Returns
    -------
    set of str
        Kinds, see `apesim.compiling.kind_of_march_types`; none where compilation is switched off.

    Examples
    --------
    >>> @entry
    ... def half(x):
    ...     return 0.5 * x
    >>> kept_kinds(half)
    set()
    """
    if config.DISABLE_JIT:
        return set()
    kinds: set[str] = compiled._cache.kept_kinds(compiled.targetctx.codegen())
    return kinds


class Chosen(Protocol):
    """Function whose body is chosen by the type of its first argument, see `by_type`."""

    bodies: dict[type, Callable[..., Any]]
    """Kernels by the NamedTuple type that they were registered for."""

    def __call__(self, first: Any, *rest: Any) -> Any:
        """Call the body for the type of the first argument."""

    def for_type(self, cls: type) -> Callable[[Function], Function]:
        """Return a decorator that registers a kernel for a NamedTuple type.

        Parameters
        ----------
        cls : type
            NamedTuple type of the first argument.

        Returns
        -------
        function
            Decorator that leaves the kernel as it is.

        Examples
        --------
        >>> from typing import NamedTuple
        >>> class Spring(NamedTuple):
        ...     rate: float
        >>> @by_type
        ... def force(p, x):
        ...     return 0.0
        >>> @force.for_type(Spring)
        ... @kernel
        ... def spring_force(p, x):
        ...     return -p.rate * x
        >>> force(Spring(rate=100.0), 0.5), force((), 0.5)
        (-50.0, 0.0)
        """


@overload
def by_type(default: Callable[..., Any], *, required: bool = ...) -> Chosen: ...
@overload
def by_type(default: None = ..., *, required: bool = ...) -> Callable[[Callable[..., Any]], Chosen]: ...
def by_type(default: Callable[..., Any] | None = None, *, required: bool = False) -> Any:
    """Make a kernel whose body is chosen, when it is compiled, by the type of its first argument.

    Parameters
    ----------
    default : function
        What is done for a type that nothing was registered for.
    required : bool
        Whether something has to be registered. The cache knows the type, but not whether the module was imported that
        registers for it: what is compiled without it would be taken for the other.

    Returns
    -------
    Chosen
        Function that can be called from Python and from kernels; or the decorator, where only ``required`` is given.

    Raises
    ------
    TypeError
        Nothing was registered for a type, and something had to be. It comes when the function is called or compiled.

    Examples
    --------
    >>> from typing import NamedTuple
    >>> class Spring(NamedTuple):
    ...     rate: float
    >>> @by_type(required=True)
    ... def force(p, x):
    ...     return 0.0
    >>> @force.for_type(Spring)
    ... @kernel
    ... def spring_force(p, x):
    ...     return -p.rate * x
    >>> force(Spring(rate=100.0), 0.5)
    -50.0
    """
    if default is None:
        return functools.partial(by_type, required=required)
    bodies: dict[type, Any] = {}
    fallback: Any = kernel(default)

    def body_for(cls: Any) -> Any:
        if required and cls not in bodies:
            name = getattr(cls, "__name__", cls)
            raise TypeError(f"nothing is registered as {fallback.__name__} of {name}: import the module that does")
        return bodies.get(cls, fallback)

    @functools.wraps(default)
    def chosen(first: Any, *rest: Any) -> Any:
        return body_for(type(first))(first, *rest)

    _let_call(chosen, lambda first: body_for(getattr(first, "instance_class", None)).compiled)

    def for_type(cls: type) -> Callable[[Function], Function]:
        def register(body: Function) -> Function:
            bodies[cls] = body
            return body

        return register

    chosen.for_type, chosen.bodies = for_type, bodies  # type: ignore[attr-defined]  # as `Chosen` has them
    return chosen
