"""How long operating points and commands take.

``python -m pytest -n 0 tests/benchmarks`` prints a table; nothing here fails on time.
"""

import pytest

from apesim.engine.steady import run_steady
from apesim.march.adaptive import TOLERANCE
from tests.benchmarks.speed import operating_points, revolution, start_times
from tests.machines import RPM, machine


def test_speed(capsys):
    lines = [f"{'engine at 1000 r/min, receiver 1 L':38s}{'time':>12s}{'cycles':>9s}"]
    lines += [f"  {'one revolution, ' + format(TOLERANCE, 'g') + ' (default)':36s}{revolution() * 1e3:9.3f} ms{1:9d}"]
    lines += [
        f"  {'operating point, ' + name:36s}{seconds * 1e3:9.3f} ms{cycles:9d}"
        for name, (seconds, cycles) in operating_points().items()
    ]
    with capsys.disabled():
        print("\n" + "\n".join(lines))


def test_start(capsys, tmp_path):
    lines = [f"{'a command from its start to its end':38s}{'time':>12s}{'memory':>12s}"]
    lines += [
        f"  {name:36s}{command.seconds:9.2f} s{command.memory / 1e6:9.0f} MB"
        for name, command in start_times(tmp_path).items()
    ]
    with capsys.disabled():
        print("\n" + "\n".join(lines))


@pytest.mark.parametrize("intake", ["epv", "cam", "ideal"])
def test_operating_point(benchmark, intake):
    a_machine = machine(intake=intake, receiver=1.0)
    assert benchmark(run_steady, a_machine, 1000.0 * RPM).orbit.converged
