"""Kernels, the entries that Python calls, and functions that are chosen by type: how they are compiled.

A function chosen by type has a body for each type of its first argument. Only an entry is compiled to be called from
Python and kept in the cache, all its kernels in it. Numba's disk cache notices an edit only in the file a function
stands in; an edited callee elsewhere would silently give the old answer. The cache folder is therefore named by a hash
of every source file that holds kernels, so that any edit opens a new, empty folder.
What is compiled for laws from outside these files has a folder within it, named by a hash of theirs.
"""

import contextlib
import functools
import hashlib
import importlib.util
import platform
import shutil
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

import llvmlite.binding
import numba
import numpy
from numba.core import event, types
from numba.core.caching import FunctionCache
from numba.core.typing.templates import AbstractTemplate, infer_global

from apesim.cache import cache_root, private_folder, temporary_folder

LAYERS = ("apesim", "apesim.valve", "apesim.engine")
UPPER_LAYERS = ("valve", "engine", "studies")
"""Folders that stand within that of `apesim` where it is installed, and beside it in a checkout."""
FOLDERS_KEPT = 4
OPTIONS = {"error_model": "numpy", "nogil": True}


def _sources():
    """Name and path of every source file that can hold kernels, in the order of the layers."""
    for layer in LAYERS:
        [folder] = importlib.util.find_spec(layer).submodule_search_locations[:1]
        for path in sorted(Path(folder).rglob("*.py")):
            name = path.relative_to(folder).as_posix()
            if layer != "apesim" or name.split("/")[0] not in UPPER_LAYERS:
                yield f"{layer}/{name}", path


@functools.cache
def sources_hash():
    """Hash of all kernel sources, of the compiler and of the processor.

    Returns
    -------
    str
        16 hexadecimal digits.
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


def _prune(root: Path, keep: Path, pattern: str) -> None:
    folders = [f for f in root.glob(pattern) if f != keep]
    folders.sort(key=lambda f: f.stat().st_mtime, reverse=True)
    for old in folders[FOLDERS_KEPT - 1 :]:
        shutil.rmtree(old, ignore_errors=True)


@functools.cache
def cache_folder():
    """The folder of the compiled kernels; they are pickles, which run code when they are read, so it is ours alone.

    Returns
    -------
    pathlib.Path
        A temporary one where none can be kept, see `apesim.cache.private_folder`.
    """
    name = f"kernels-{sources_hash()}"
    try:
        is_new = not (cache_root() / name).exists()
    except RuntimeError:  # the user has no home folder
        return temporary_folder(name)
    folder = private_folder(name)
    if folder is None:
        return temporary_folder(name)
    if is_new:
        _prune(folder.parent, keep=folder, pattern="kernels-*")
    return folder


@contextlib.contextmanager
def when_compiling(tell):
    """Within, call a function once as soon as anything has to be compiled; what is loaded from the cache has not.

    Parameters
    ----------
    tell : function
        Of nothing.
    """
    with event.install_listener("numba:compile", _Once(tell)):
        yield


class _Once(event.Listener):
    """Calls a function when the first event starts."""

    def __init__(self, tell):
        self.tell = tell

    def on_start(self, event):
        tell, self.tell = self.tell, None
        if tell:
            tell()

    def on_end(self, event):
        pass


def outside_folder(outside_hash: str) -> Path:
    """The folder of what is compiled for laws from outside the layers' files, within that of the compiled kernels.

    Parameters
    ----------
    outside_hash : str
        Hash of the files that they stand in.

    Returns
    -------
    pathlib.Path
    """
    folder = cache_folder() / f"outside-{outside_hash}"
    if not folder.exists():
        folder.mkdir(mode=0o700, exist_ok=True)
        _prune(cache_folder(), keep=folder, pattern="outside-*")
    return folder


def outside_hash_of(arguments: Iterable[types.Type]) -> str:
    """Hash of the files from outside the layers that the laws of a call stand in; "" where there are none.

    Parameters
    ----------
    arguments : iterable of numba types
        A NamedTuple class among them, at any depth, that holds such laws says the hash as ``outside_hash``.

    Returns
    -------
    str
    """
    for kind in arguments:
        if isinstance(kind, types.BaseTuple):
            outside_hash = getattr(getattr(kind, "instance_class", None), "outside_hash", "") or outside_hash_of(kind)
            if outside_hash:
                return outside_hash
    return ""


class _SelfHealingCache(FunctionCache):
    """A kernel's cache that compiles anew where a file of it is damaged."""

    def load_overload(self, sig, target_context):
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # a garbled pickle raises anything, a MemoryError too
            self.flush()
            return None

    def save_overload(self, sig, data):
        try:
            super().save_overload(sig, data)
        except Exception:
            self.flush()
            super().save_overload(sig, data)


class _EntryCache(_SelfHealingCache):
    """An entry's cache; what is compiled for laws from outside is kept apart.

    An index that names a type which no file has brought into this process could not be read.
    """

    def __init__(self, function):
        super().__init__(function)
        self._function, self._apart = function, {}

    def _cache_for(self, sig):
        outside_hash = outside_hash_of(sig)
        if outside_hash and outside_hash not in self._apart:
            self._apart[outside_hash] = _cache_in(outside_folder(outside_hash), _SelfHealingCache, self._function)
        return self._apart.get(outside_hash, super())

    def load_overload(self, sig, target_context):
        return self._cache_for(sig).load_overload(sig, target_context)

    def save_overload(self, sig, data):
        self._cache_for(sig).save_overload(sig, data)


def _cache_in(folder: Path, kind: type, function: Callable) -> FunctionCache:
    """A cache of a function's compiled forms, of the given kind, in a folder."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(folder)
    try:
        return kind(function)
    finally:
        numba.config.CACHE_DIR = before


def _let_call(function, body_for):
    """Let compiled code call a function of Python by the kernel that it has for the type of the first argument."""

    class Call(AbstractTemplate):
        key = function

        def generic(self, args, kws):
            return types.Dispatcher(body_for(args[0])).get_call_type(self.context, args, kws)

        def get_impl_key(self, signature):
            return body_for(signature.args[0]).get_overload(signature.args)

    infer_global(function, types.Function(Call))


def kernel(function=None, *, inline=True):
    """Let a pure function of floats, arrays and NamedTuples be compiled into the kernels that call it.

    Called from Python it stays the function it is: what unpacks a machine's parameters from Python takes as long to
    compile as a law. Without fast-math, so that compiled and plain Python (``NUMBA_DISABLE_JIT=1``) give the same
    bits.

    Parameters
    ----------
    function : function
    inline : bool
        A law is laid into its callers: handing it the parameters would cost more than the law. Not so the long
        functions that are called in several places.
    """
    if function is None:
        return functools.partial(kernel, inline=inline)
    bare = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "forceinline": inline}
    function.compiled = numba.njit(**OPTIONS, **bare)(function)
    _let_call(function, lambda first: function.compiled)
    return function


def entry(function):
    """Compile a function that is called from Python, with all kernels that it calls, and keep it in the cache."""
    compiled = numba.njit(**OPTIONS, no_cfunc_wrapper=True)(function)
    if not numba.config.DISABLE_JIT:
        compiled._cache = _cache_in(cache_folder(), _EntryCache, function)
    return compiled


def by_type(default=None, *, required=False):
    """A kernel whose body is chosen, when it is compiled, by the type of its first argument.

    Parameters
    ----------
    default : function
        What is done for a type that nothing was registered for.
    required : bool
        Something has to be registered; else `TypeError`. The cache knows the type, but not whether the module was
        imported that registers for it: what is compiled without it would be taken for the other.

    Returns
    -------
    function
        Callable from Python and from kernels. ``for_type(cls)`` registers a kernel for the NamedTuple ``cls``;
        ``bodies`` has those registered.
    """
    if default is None:
        return functools.partial(by_type, required=required)
    bodies, default = {}, kernel(default)

    def body_for(cls):
        if required and cls not in bodies:
            name = getattr(cls, "__name__", cls)
            raise TypeError(f"nothing is registered as {default.__name__} of {name}: import the module that does")
        return bodies.get(cls, default)

    @functools.wraps(default)
    def chosen(first, *rest):
        return body_for(type(first))(first, *rest)

    _let_call(chosen, lambda first: body_for(getattr(first, "instance_class", None)).compiled)

    def for_type(cls):
        def register(body):
            bodies[cls] = body
            return body

        return register

    chosen.for_type, chosen.bodies = for_type, bodies
    return chosen
