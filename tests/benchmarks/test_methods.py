"""Methods for the bench beside each other, and operating points.

``python -m pytest -n 0 tests/benchmarks`` prints the times; nothing here fails on one.
"""

import pytest

from apesim.engine.steady import run_steady
from tests.benchmarks.methods import FIXED_STEP, compare, table
from tests.machines import RPM, machine


def test_all_methods_meet_the_contacts(capsys):
    found = compare(turns=1)
    with capsys.disabled():
        print("\n" + "\n".join(table(found)))
    assert all(each.off < 10.0 * FIXED_STEP for each in found)


@pytest.mark.parametrize("intake", ["epv", "cam", "ideal"])
def test_operating_point(benchmark, intake):
    a_machine = machine(intake=intake, receiver=1.0)
    assert benchmark(run_steady, a_machine, 1000.0 * RPM).orbit.converged
