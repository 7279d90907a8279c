"""How long the usual runs take, and what a fixed step and a general solver take for the same.

``python -m pytest -n 0 tests/benchmarks/test_speed.py`` prints a table; nothing here fails on time.
"""

import pytest

from apesim.engine.steady import run_steady
from apesim.march.adaptive import TOLERANCE
from tests.benchmarks.speed import FIXED_STEP, bench_rows, operating_points, revolution, start_times
from tests.machines import RPM, machine


def test_speed(capsys):
    rows = bench_rows()
    ours = rows["march, 1e-6"][0]
    lines = [f"{'bench, one stroke cycle of 100 ms':38s}{'time':>12s}{'ratio':>9s}{'contacts off by':>18s}"]
    lines += [
        f"  {name:36s}{seconds * 1e3:9.3f} ms{seconds / ours:9.2f}{error * 1e6:15.4f} us"
        for name, (seconds, error) in rows.items()
    ]
    lines += ["", f"{'engine at 1000 r/min, receiver 1 L':38s}{'time':>12s}{'cycles':>9s}"]
    lines += [f"  {'one revolution, ' + format(TOLERANCE, 'g') + ' (default)':36s}{revolution() * 1e3:9.3f} ms{1:9d}"]
    lines += [
        f"  {'operating point, ' + name:36s}{seconds * 1e3:9.3f} ms{cycles:9d}"
        for name, (seconds, cycles) in operating_points().items()
    ]
    with capsys.disabled():
        print("\n" + "\n".join(lines))
    assert all(error < 10.0 * FIXED_STEP for _, error in rows.values())


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
