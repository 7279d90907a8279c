"""Arrays of a page, packed once each, however many figures show them."""

import base64

import numpy as np

MAX_EXACT = 200
"""Numbers up to which an array keeps all its digits; longer ones are traces, for whose hover seven digits do."""


class ArrayPool:
    """Arrays of a page in the order in which figures took them; an array that is there already is taken again."""

    def __init__(self) -> None:
        self.arrays: list[dict[str, str]] = []
        self.samples = 0
        self._numbers: dict[tuple[str, bytes], int] = {}

    def add(self, values: np.ndarray, *, is_exact: bool = False) -> int:
        """Pack an array of numbers, NaN for a missing one, and give its number in the pool.

        An exact one keeps all digits, however long it is.

        >>> pool = ArrayPool()
        >>> pool.add(np.array([1.0, 2.0])), pool.add(np.array([1.0, 2.0])), pool.samples
        (0, 0, 2)
        """
        kind = "f8" if is_exact or values.size <= MAX_EXACT else "f4"
        packed = np.ascontiguousarray(values, dtype=f"<{kind}").tobytes()
        key = kind, packed
        if key not in self._numbers:
            self._numbers[key] = len(self.arrays)
            self.arrays.append({kind: base64.b64encode(packed).decode("ascii")})
            self.samples += values.size
        return self._numbers[key]
