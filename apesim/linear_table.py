"""Tables that are linear between their rows and constant beyond."""

import numpy as np

from apesim.kernel import kernel


@kernel
def read_table(table: np.ndarray, x: float, column: int = 1) -> float:
    """Read a column of a table (n, c) at a value of its first one, which ascends: linear, the ends hold beyond.

    >>> table = np.array([[0.0, 4.0], [20.0, 8.0]])
    >>> [float(read_table(table, x)) for x in (-1.0, 5.0, 30.0)]
    [4.0, 5.0, 8.0]
    """
    last = table.shape[0] - 1
    if x <= table[0, 0]:
        return table[0, column]
    if x >= table[last, 0]:
        return table[last, column]
    i = 0
    while x > table[i + 1, 0]:
        i += 1
    share = (x - table[i, 0]) / (table[i + 1, 0] - table[i, 0])
    return table[i, column] + share * (table[i + 1, column] - table[i, column])
