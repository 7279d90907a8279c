"""The bench against a program in C of the same equations and method, which the benchmarks compare times with."""

import pytest

from tests.benchmarks.c_program import COMPILER, CProgram
from tests.benchmarks.methods import COMPARED, END, PULSE, TRUE, BenchCycle

pytestmark = pytest.mark.skipif(not COMPILER, reason="no gcc to compile bench_march.c with")


@pytest.fixture(scope="module")
def in_c(tmp_path_factory):
    return CProgram(tmp_path_factory.mktemp("c"))


@pytest.mark.parametrize(("tolerance", "error"), [(COMPARED, 1e-6), (TRUE, 1e-10)])
def test_it_meets_the_contacts_of_a_fine_march(in_c, tolerance, error):
    found = in_c.run(PULSE, END, tolerance, repeats=1).contacts
    assert found == pytest.approx(BenchCycle().contacts(TRUE), rel=0.0, abs=error)


def test_it_evaluates_the_rates_as_often_or_a_ratio_of_times_says_nothing(in_c):
    ours = BenchCycle().march(COMPARED).evaluations
    assert in_c.run(PULSE, END, COMPARED, repeats=1).evaluations == pytest.approx(ours, rel=0.02)
