"""Kernels that are linked before they are optimised: an entry and all that it calls become machine code at once.

Numba optimises every function and turns it into machine code as soon as it is compiled, though nothing but the entry
is ever called from Python. That takes longer than all else of a first run. Here a kernel is kept as it was written
down, and its callers take it from there. Whoever else calls it, an ``@numba.njit`` function for instance, lets it be
compiled like any other function.

What stands here knows Numba from within. With a release that it was not tried with, kernels are compiled like any
other function: a first run takes longer, to the same digits.
"""

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import llvmlite.binding
import numba
from numba.core import cgutils, compiler, config, types
from numba.core.codegen import JITCodeLibrary, RuntimeLinker

TRIED_FROM, TRIED_BEFORE = (0, 63), (0, 69)
"""Releases of Numba that this was tried with, the last one not among them."""
OPTIMISATION = 2
"""Level of LLVM's passes, at most that of Numba; the third takes a second more, and its marches are no faster."""
PASSES_BEFORE = (
    "sroa",
    "always_inliner",
    "global_dead_code_eliminate",
    "sroa",
    "loop_rotate",
    "instruction_combine",
    "jump_threading",
    "refprune",
)
"""Passes before those of the level, by their names in llvmlite. Tuples are taken apart while they are few; references
to arrays that are counted up and down are dropped before anything comes between: else a march takes 4 % more."""
OF_NUMBERS = ("_operator", "builtins", "math")
"""Modules whose functions are typed once for each kind of numbers."""


def jit(function: Callable[..., Any], **options: Any) -> Any:
    """Let Numba compile a function for its callers, which optimise it together with themselves.

    Options are those of ``numba.njit``; returns the plain function where compilation is switched off.
    """
    if TRIED_FROM <= numba.version_info.short < TRIED_BEFORE:
        options["pipeline_class"] = _Compiler
    return numba.njit(**options)(function)


class _Library(JITCodeLibrary):  # type: ignore[misc]  # numba has no types
    """Code of a kernel or an entry: modules as they were written down, until machine code is asked for."""

    def __init__(self, codegen: Any, name: str) -> None:
        super().__init__(codegen, name)
        self._modules: list[Any] = []
        self._environments: dict[str, Any] = {}

    def add_ir_module(self, ir_module: Any) -> None:
        """Keep a module, without optimising anything."""
        self._raise_if_finalized()
        module = llvmlite.binding.parse_assembly(cgutils.normalize_ir_text(str(ir_module)))
        module.data_layout = self._codegen._data_layout
        self._modules.append(module)

    def add_linking_library(self, library: Any) -> None:
        """Note a library that is called; a kernel's need not be finished."""
        if not isinstance(library, _Library):
            library._ensure_finalized()
        self._linking_libraries.append(library)

    def get_pointer_to_function(self, name: str) -> int:
        """Address of a function for Python, for which the whole becomes machine code; 0 where it has none."""
        if name not in self._own_functions():
            return 0
        address: int = super().get_pointer_to_function(name)
        return address

    def _own_functions(self) -> set[str]:
        return {f.name for module in self._modules for f in module.functions if not f.is_declaration}

    def _called(self) -> list[Any]:
        """All libraries that are called, directly or not, each once, itself the first."""
        found: dict[Any, None] = {self: None}
        waiting: list[Any] = [self]
        while waiting:
            for library in waiting.pop()._linking_libraries:
                if library not in found:
                    found[library] = None
                    if isinstance(library, _Library):
                        waiting.append(library)
        return list(found)

    def finalize(self) -> None:
        """Link all that is called, optimise it, and turn it into machine code."""
        self._raise_if_finalized()
        self._codegen._check_llvm_bugs()
        own, called = self._own_functions(), self._called()
        kernels = [library for library in called if isinstance(library, _Library)]
        others = [library for library in called if not isinstance(library, _Library)]
        for library in called:
            self._reload_init.update(library._reload_init)
        # Those of Numba come last: of them the linker takes only what is called by then.
        for module in (module for kernel in kernels for module in kernel._modules):
            self._final_module.link_in(module, preserve=True)
        for library in others:
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._hide_all_but(own)
        self._optimize_final_module()
        self._final_module.verify()
        self._finalize_final_module()
        present = {variable.name for variable in self._final_module.global_variables}
        for name, environment in (item for kernel in kernels for item in kernel._environments.items()):
            if name in present:
                self._codegen.set_env(name, environment)

    def _hide_all_but(self, own: set[str]) -> None:
        """Let nobody else call the functions that were linked, so that what is inlined everywhere is dropped."""
        prefix = RuntimeLinker.PREFIX  # of what is called by its address, in recursions
        by_address = {v.name.removeprefix(prefix) for v in self._final_module.global_variables if prefix in v.name}
        for function in self._final_module.functions:
            if not function.is_declaration and function.name not in own:
                function.linkage = "weak_odr" if function.name in by_address else "internal"

    def _optimize_final_module(self) -> None:
        passes = llvmlite.binding.create_new_module_pass_manager()
        for name in PASSES_BEFORE:
            getattr(passes, f"add_{name}_pass")()
        passes.run(self._final_module, self._codegen._pass_builder(opt=0))
        level = min(OPTIMISATION, config.OPT)
        passes, builder = self._codegen._module_pass_manager(opt=level, loop_vectorize=False, slp_vectorize=False)
        passes.run(self._final_module, builder)

    @property
    def codegen(self) -> Any:
        """Itself until there is machine code, to note the environments that will be set in it."""
        return self._codegen if self._finalized else self

    def set_env(self, name: str, environment: Any) -> None:
        """Note the environment of a function."""
        self._environments[name] = environment


class _Flags(compiler.Flags):  # type: ignore[misc]  # numba has no types
    """Options of a compilation; Numba compares them some ten thousand times, and they change no more."""

    __slots__ = ("_known_values",)

    def values(self) -> dict[str, Any]:
        try:
            known: dict[str, Any] = self._known_values
        except AttributeError:
            self._known_values = known = super().values()
        return known


class _Compiler(compiler.Compiler):  # type: ignore[misc]  # numba has no types
    """Numba's compiler of a kernel or an entry, into a `_Library`."""

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile a function."""
        self.state.library = _Library(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        self.state.flags = _Flags(self.state.flags)
        with _without_collector(), _typing_once(self.state.typingctx):
            return super().compile_extra(func)


@contextmanager
def _without_collector() -> Iterator[None]:
    """Without looking for garbage, which takes a tenth of the time; a kernel within another changes nothing."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


@contextmanager
def _typing_once(context: Any) -> Iterator[None]:
    """Look up once what an operator makes of numbers: Numba asks dozens of its overloads, at each place anew."""
    if "resolve_function_type" in vars(context):  # a kernel within another
        yield
        return
    resolve, known = context.resolve_function_type, {}

    def resolve_once(function: Any, arguments: Any, keywords: Any) -> Any:
        of_numbers = (
            isinstance(function, types.Function)
            and not keywords
            and getattr(function.typing_key, "__module__", "") in OF_NUMBERS
            and all(isinstance(a, types.Number | types.Boolean) for a in arguments)
        )
        if not of_numbers:
            return resolve(function, arguments, keywords)
        key = function, tuple(arguments)
        if key not in known:
            known[key] = resolve(function, arguments, keywords)
        return known[key]

    context.resolve_function_type = resolve_once
    try:
        yield
    finally:
        del context.resolve_function_type
