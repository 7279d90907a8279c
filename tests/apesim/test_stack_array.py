import numba
import numpy as np

from apesim.kernel import kernel
from apesim.stack_array import zeros


@kernel
def one_added(i):
    room = zeros(5)
    room[i] += 1.0
    return room[0] + 10.0 * room[1] + 100.0 * room[2] + 1000.0 * room[3] + 10000.0 * room[4] + 1e5 * room.shape[0]


def sums(times, found):
    for n in range(times):
        found[n] = one_added(n % 5)


def test_it_is_zero_each_time_it_is_asked_for():
    found = np.zeros(1000)
    (sums if numba.config.DISABLE_JIT else numba.njit(sums))(1000, found)
    assert found.tolist() == [5e5 + 10.0 ** (n % 5) for n in range(1000)]


def test_a_kernel_that_is_called_from_python_gets_one_too():
    assert one_added(3) == 5e5 + 1000.0
