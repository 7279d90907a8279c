"""Parameters and arrays of a machine as one row of numbers, and compiled code that makes them of such a row again."""

from collections.abc import Iterator
from typing import Any, cast

import numpy as np
from numba import typeof
from numba.core import types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array

NUMBER_SIZE = 8
"""Size of a number, floating or whole [bytes]."""


def flatten(value: Any) -> np.ndarray:
    """Write a tuple of numbers, arrays and such tuples as one row of numbers (n,), in order; None has none.

    Whole numbers of an array stand there by their bits: compiled code reads them in place.

    >>> flatten((1.5, (2, None), np.array([[3.0, 4.0]]))).tolist()
    [1.5, 2.0, 3.0, 4.0]
    """
    return np.concatenate([np.empty(0), *_parts_of(value)])


def _parts_of(value: Any) -> Iterator[np.ndarray]:
    """Rows of the numbers of a value."""
    if isinstance(value, tuple):
        for member in value:
            yield from _parts_of(member)
    elif isinstance(value, np.ndarray):
        yield np.ascontiguousarray(value).reshape(-1).view(np.float64)
    elif value is not None:
        yield np.array([float(value)])


def unflattener(example: Any) -> Any:
    """Make an intrinsic function from the address of a row of numbers to a tuple with the types and shapes of another.

    Its arrays are views of the row: what is written there is seen by whoever holds them.
    """

    @intrinsic
    def unflatten(typing_context: Any, address: Any) -> Any:
        kind = typeof(example)

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return _build(context, builder, arguments[0], kind, example, 0)[0]

        return kind(address), generate

    return unflatten


def _build(context: Any, builder: Any, address: Any, kind: Any, example: Any, taken: int) -> tuple[Any, int]:
    """Value of a type whose numbers begin behind those that are taken, and how many are taken then."""
    if isinstance(kind, types.BaseTuple):
        members = []
        for member_kind, member in zip(cast(Any, kind), example, strict=True):
            value, taken = _build(context, builder, address, member_kind, member, taken)
            members.append(value)
        return context.make_tuple(builder, kind, members), taken
    if isinstance(kind, types.NoneType):
        return context.get_dummy_value(), taken
    place = builder.gep(address, [context.get_constant(types.intp, taken)])
    if isinstance(kind, types.Array):
        array = make_array(kind)(context, builder)
        shape, strides = ([context.get_constant(types.intp, n) for n in ns] for ns in (example.shape, example.strides))
        first = builder.bitcast(place, context.get_data_type(kind.dtype).as_pointer())
        populate_array(array, first, shape=shape, strides=strides, itemsize=NUMBER_SIZE, meminfo=None)
        return array._getvalue(), taken + example.size
    return context.cast(builder, builder.load(place), types.float64, kind), taken + 1
