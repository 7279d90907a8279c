"""Native code: a function of Python with all that it calls as an object file, without a symbol of Python."""

from typing import Any

import llvmlite.binding as llvm

from apesim.kernel import OPTIONS
from apesim.linking import jit
from apesim.march import adaptive

BARE: dict[str, Any] = OPTIONS | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Options of what only compiled code calls: what wraps it for others has symbols of Python."""
march: Any = jit(getattr(adaptive.march, "py_func", adaptive.march), **BARE)
"""The march, to be compiled into its callers: it is kept in no cache."""
PROCESSOR = "x86-64-v2"
"""Processor that is compiled for, as LLVM names it: those of 2009 and later. One with more is no faster here."""
OPTIMISATION = 2
"""Level at which machine code is chosen."""


def compile_module(function: Any, signature: Any, name: str) -> Any:
    """Compile a function of a signature for Numba, with all that it calls, into a module of LLVM.

    It is a function of C with the name for what it is linked with; nothing is seen from outside of that. Numba has to
    have been told of the `PROCESSOR` by its environment.
    """
    entry = jit(function, **BARE)
    entry.compile(signature)
    (compiled,) = entry.overloads.values()
    compiled.library._ensure_finalized()
    module = llvm.parse_assembly(compiled.library.get_llvm_str().replace(compiled.fndesc.llvm_func_name, name))
    for symbol in (*module.functions, *module.global_variables):
        if not symbol.is_declaration and symbol.name != name:
            symbol.linkage = "internal"
    module.get_function(name).visibility = "hidden"  # or the step of another library might be called in its place
    return module


def emit_object(module: Any, triple: str) -> bytes:
    """Turn a module into an object file for a platform, named by LLVM's triple; the module is changed."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(triple).create_target_machine(
        cpu=PROCESSOR, features="", opt=OPTIMISATION, reloc="pic", codemodel="default"
    )
    module.triple, module.data_layout = triple, str(machine.target_data)
    code: bytes = machine.emit_object(module)
    return code
