"""Kernels become machine code once, with the entry or the function of others that calls them."""

import gc

import numba
import numpy as np
import pytest

from apesim import linking
from apesim.kernel import by_type, entry, kernel
from apesim.linking import jit

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")


@kernel
def squared(x):
    return x * x


@kernel(inline=False)
def filled(x, out):
    for i in range(out.shape[0]):
        out[i] = squared(x) + i


def library_of(function):
    (compiled,) = function.compiled.overloads.values()
    return compiled.library


def test_a_kernel_is_linked_into_its_entry_and_has_no_machine_code_of_its_own():
    @kernel
    def halved(x):
        return 0.5 * x

    @jit
    def outermost(x):
        return halved(squared(x))

    assert outermost(3.0) == 4.5
    assert not library_of(halved)._finalized
    (compiled,) = outermost.overloads.values()
    assert compiled.library._finalized


@pytest.mark.parametrize("release", [(0, 61), linking.TRIED_BEFORE])
def test_with_a_release_of_numba_that_was_not_tried_it_is_compiled_as_any_function(release, monkeypatch):
    def halved(x):
        return 0.5 * x

    monkeypatch.setattr(numba, "version_info", numba.version_info._replace(short=release))
    compiled = jit(halved)
    assert compiled(3.0) == 1.5
    (overload,) = compiled.overloads.values()
    assert not isinstance(overload.library, linking._Library)


@kernel
def read_off(x):
    """A kernel from outside, which makes an array; ours make none."""
    return np.interp(x, np.array([0.0, 1.0]), np.array([0.0, 2.0]))


@entry
def read_off_twice(x):
    return read_off(x) + read_off(0.5 * x)


def test_a_kernel_from_outside_makes_an_array():
    assert read_off_twice(1.0) == 3.0


def test_an_ordinary_function_of_numba_calls_a_kernel():
    @numba.njit
    def total(x, n):
        out = np.empty(n)
        filled(x, out)
        return out.sum()

    assert total(2.0, 3) == 3 * 4.0 + 3.0


def test_a_kernel_serves_an_entry_and_an_ordinary_function_one_after_the_other():
    @kernel
    def thrice(x):
        return 3.0 * x

    of_others = numba.njit(lambda x: thrice(x) + 1.0)
    ours = jit(lambda x: thrice(x) - 1.0)
    assert (of_others(1.0), ours(1.0)) == (4.0, 2.0)


def test_numbas_own_functions_stay_as_they_are_for_others():
    """An entry may be the first that calls one of them: then others find it compiled, not laid bare."""

    @jit
    def ours(values):
        return np.sort(values)[0]

    @numba.njit
    def of_others(values):
        return np.sort(values)[-1]

    values = np.array([3.0, 1.0, 2.0])
    assert (ours(values), of_others(values)) == (1.0, 3.0)


@pytest.mark.parametrize("was_on", [True, False])
def test_the_collector_is_as_it_was_after_compiling(was_on):
    (gc.enable if was_on else gc.disable)()
    try:
        assert jit(lambda x: squared(x) + 7.0)(2.0) == 11.0
        assert gc.isenabled() == was_on
    finally:
        gc.enable()


def test_a_kernel_fills_what_its_entry_makes():
    @entry
    def made(x):
        out = np.empty(4)
        filled(x, out)
        return out

    assert made(1.0).tolist() == [1.0, 2.0, 3.0, 4.0]


def test_a_body_is_chosen_by_type_within_an_entry():
    @by_type
    def weight(p, x):
        return x

    assert jit(lambda x: weight(x, 2.0))(1.0) == 2.0
