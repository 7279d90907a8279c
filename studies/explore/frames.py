"""Answers to the page as bytes: a header as JSON, and curves as numbers of four bytes behind it.

Length of the header (4 bytes), header, curves in the order of its ``curves``, all little-endian; the header ends with
spaces so that the curves begin at a multiple of four.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic_core import to_json

ALIGNMENT = 4
"""Bytes of a number: curves begin at a multiple of it, as browsers need it."""


def encode_frame(header: Mapping[str, Any], curves: Mapping[str, np.ndarray]) -> bytes:
    """Write a frame; NaN in the header becomes null, in curves it stays.

    >>> frame = encode_frame({"number": 3}, {"lift": np.array([0.0, 1.0])})
    >>> frame[4:-8]
    b'{"number":3,"curves":[["lift",2]]}  '
    """
    sizes = [[name, len(values)] for name, values in curves.items()]
    head = encode_text({**header, "curves": sizes})
    head += b" " * (-len(head) % ALIGNMENT)
    numbers = b"".join(np.ascontiguousarray(values, "<f4").tobytes() for values in curves.values())
    return len(head).to_bytes(4, "little") + head + numbers


def encode_text(data: Any) -> bytes:
    """Write JSON that browsers read: NaN and infinity become null."""
    return to_json(data, inf_nan_mode="null", fallback=lambda value: value.item())
