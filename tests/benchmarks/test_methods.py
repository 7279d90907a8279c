"""Methods for the bench beside each other: they meet the same contacts. Nothing here fails on time.

``python -m pytest -n 0 tests/benchmarks`` prints the times.
"""

import pytest

from tests.benchmarks.c_program import COMPILER, CProgram
from tests.benchmarks.methods import COMPARED, END, FIXED_STEP, PULSE, TRUE, BenchCycle, compare, table


@pytest.mark.skipif(not COMPILER, reason="no gcc to compile bench_march.c with")
def test_the_program_in_c_does_the_same_as_the_march(tmp_path):
    """It meets the contacts of a fine march, and takes as many steps: otherwise a ratio of times says nothing."""
    bench, program = BenchCycle(), CProgram(tmp_path)
    coarse, fine = (program.run(PULSE, END, tolerance, repeats=1) for tolerance in (COMPARED, TRUE))
    assert coarse.contacts == pytest.approx(bench.contacts(TRUE), rel=0.0, abs=1e-6)
    assert fine.contacts == pytest.approx(bench.contacts(TRUE), rel=0.0, abs=1e-10)
    assert coarse.evaluations == pytest.approx(bench.march(COMPARED).evaluations, rel=0.02)


def test_all_methods_meet_the_contacts(capsys):
    found = compare(turns=1)
    with capsys.disabled():
        print("\n" + "\n".join(table(found)))
    assert all(each.off < 10.0 * FIXED_STEP for each in found)
