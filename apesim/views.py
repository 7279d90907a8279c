"""Parts of an array as views that a kernel can hand on: compiled without reference counts, none may return a slice."""

from typing import Any

import numba
import numpy as np
from numba.core import types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array


def part_of(length: int, stride: int) -> Any:
    """Make a function from an array (n,) and a number i to a view of a part of it, (length,), from i times stride on.

    >>> pair = part_of(2, 2)
    >>> pair(np.arange(6.0), 1).tolist()
    [2.0, 3.0]
    """

    def plain(array: np.ndarray, i: int) -> np.ndarray:
        return array[stride * i : stride * i + length]

    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]  # numba sets its options from the environment
        return plain

    @intrinsic
    def part(typing_context: Any, array: Any, i: Any) -> Any:
        """Return a view of a part of an array; it does not outlive the array."""
        kind = types.Array(types.float64, 1, "C")

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            whole = make_array(signature.args[0])(context, builder, arguments[0])
            count, step, size = (context.get_constant(types.intp, n) for n in (length, stride, 8))
            view = make_array(kind)(context, builder)
            first = builder.gep(whole.data, [builder.mul(arguments[1], step)])
            populate_array(view, first, shape=[count], strides=[size], itemsize=size, meminfo=None)
            return view._getvalue()

        return kind(array, types.intp), generate

    class AlsoPlain(type(part)):  # type: ignore[misc]
        """Intrinsic that can be called as plain Python, too."""

        def __call__(self, array: np.ndarray, i: int) -> np.ndarray:
            return plain(array, i)

    part.__class__ = AlsoPlain
    return part
