"""Tuples of parameters packed into rows of numbers, so that kernels take one of several alike by its index.

A tuple of several machines has a Numba type for each number of them, and a march would be compiled for each.
"""

from collections.abc import Iterator
from typing import Any

import numba
import numpy as np
from numba.core import types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array


def numbers_in(parameters: Any) -> Iterator[float]:
    """Yield the numbers of a tuple, at any depth and in order; what is None has none.

    >>> list(numbers_in((1.5, (2, None), 3.0)))
    [1.5, 2.0, 3.0]
    """
    for value in parameters:
        if isinstance(value, tuple):
            yield from numbers_in(value)
        elif value is not None:
            yield float(value)


def packed(parameters: Any) -> np.ndarray:
    """Pack tuples that differ in numbers alone into rows: (n, m) of n tuples with m numbers each.

    >>> packed([(1.5, (2, None)), (0.5, (4, None))]).tolist()
    [[1.5, 2.0], [0.5, 4.0]]
    """
    return np.array([list(numbers_in(each)) for each in parameters])


@intrinsic
def _unpacked(typing_context: Any, template: Any, rows: Any, index: Any) -> Any:
    """Return a tuple of the template's type, with the numbers of a row."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array = make_array(signature.args[1])(context, builder, arguments[1])
        width = builder.extract_value(array.shape, 1)
        first = builder.gep(array.data, [builder.mul(arguments[2], width)])
        taken = 0

        def build(kind: Any) -> Any:
            nonlocal taken
            if isinstance(kind, types.BaseTuple):
                return context.make_tuple(builder, kind, [build(member) for member in kind])
            if isinstance(kind, types.NoneType):
                return context.get_dummy_value()
            number = builder.load(builder.gep(first, [context.get_constant(types.intp, taken)]))
            # The rows stay as they are: what is read late need not be kept on the stack all the while.
            number.set_metadata("invariant.load", builder.module.add_metadata([]))
            taken += 1
            return context.cast(builder, number, types.float64, kind)

        return build(template)

    return template(template, rows, types.intp), generate


def _from_row(template: Any, numbers: Iterator[float]) -> Any:
    """A tuple of the template's types, with the next numbers."""
    values: list[Any] = []
    for value in template:
        if isinstance(value, tuple):
            values.append(_from_row(value, numbers))
        else:
            values.append(None if value is None else type(value)(next(numbers)))
    return type(template)(*values) if hasattr(template, "_fields") else tuple(values)


class _AlsoPlain(type(_unpacked)):  # type: ignore[misc]
    """Intrinsic that can be called as plain Python, too."""

    def __call__(self, template: Any, rows: np.ndarray, index: int) -> Any:
        return _from_row(template, iter(rows[index].tolist()))


unpacked: Any = _unpacked
"""Function from a template, rows (n, m) in C order and an index to a tuple like the template, with that row's numbers.

>>> unpacked((0.0, (0, None)), np.array([[1.5, 2.0], [0.5, 4.0]]), 1)
(0.5, (4, None))
"""
if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]  # numba sets its options from the environment

    def unpacked(template: Any, rows: np.ndarray, index: int) -> Any:
        """Return a tuple like the template, with the numbers of a row."""
        return _from_row(template, iter(rows[index].tolist()))
else:
    unpacked.__class__ = _AlsoPlain
