"""Room for a few numbers on a kernel's stack: an array from the heap costs as much as all the laws that fill it."""

from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array

DOUBLE = ir.DoubleType()


@intrinsic(prefer_literal=True)
def _zeros(typing_context: Any, count: Any) -> Any:
    """Return an array of zeros on the stack, its length a constant; it ends with the kernel that asks for it.

    Laid down where it is asked for: from a function between, it would not outlive that function.
    """
    kind = types.Array(types.float64, 1, "C")

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        room = ir.ArrayType(DOUBLE, count.literal_value)
        data = cgutils.alloca_once(builder, room)
        builder.store(ir.Constant(room, None), data)
        length, size = (context.get_constant(types.intp, n) for n in (count.literal_value, 8))
        array = make_array(kind)(context, builder)
        first = builder.bitcast(data, DOUBLE.as_pointer())
        populate_array(array, first, shape=[length], strides=[size], itemsize=size, meminfo=None)
        return array._getvalue()

    return kind(count), generate


class _AlsoPlain(type(_zeros)):  # type: ignore[misc]
    """Intrinsic that kernels can call as plain Python, too: they then get an array from the heap."""

    def __call__(self, count: int) -> np.ndarray:
        return np.zeros(count)


zeros: Any = _zeros
"""Function from a constant length to an array of zeros, float64; in a kernel it ends with the kernel."""
if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]  # numba sets its options from the environment
    zeros = np.zeros
else:
    zeros.__class__ = _AlsoPlain
