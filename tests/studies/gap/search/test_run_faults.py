"""Faults of measurement of one file, as candidates."""

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.estimation.noise.process import white
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.gap.search.run_faults import find_run_faults, leave_out, list_faults
from apesim.studies.measured import Measured, MeasuredRun
from apesim.studies.measured.prediction import predict, run_of

TIMES = np.arange(0.0, 0.1, 1e-3)


def run(number, sensors=("lift", "pressure_a", "pressure_b")):
    channels = dict.fromkeys(sensors, TIMES)
    record = MeasuredRun(f"p{number}", f"p{number}.csv", 0.5e6, 287.0, 50e-3, "fit", TIMES, channels)
    return record._replace(channels=predict(run_of(Machine(), record), record).channels)


def test_of_two_files_none_is_the_odd_one():
    assert find_run_faults(Measured("", {}, (run(1), run(2)), "valve")) == []
    assert len(find_run_faults(Measured("", {}, (run(1), run(2), run(3)), "valve"))) == 3 * 11


def test_runs_of_one_file_have_its_faults_once():
    ways = [run(1)._replace(name=f"way {number}") for number in range(4)]
    faults = find_run_faults(Measured("", {}, (*ways, run(2), run(3)), "valve"))
    assert len({fault.name for fault in faults}) == len(faults)


@pytest.mark.parametrize("fault", list(list_faults(run(2))), ids=lambda fault: fault.name)
def test_a_fault_changes_its_own_file_alone(fault):
    runs = [run(1), run(2), run(3)]
    noise = {
        "lift": {1e-3: white(3e-5, "stated")},
        "pressure_a": {1e-3: white(2e3, "stated")},
        "pressure_b": {1e-3: white(2e3, "stated")},
    }
    residuals = WhitenedResiduals(Machine(), runs, fault.strengths, noise)
    sizes = [np.abs(part).max() for part in residuals.by_block(residuals.at(np.array([0.2])))]
    files = [block.run.file for block in residuals.blocks]
    assert max(size for size, file in zip(sizes, files, strict=True) if file == "p2.csv") > 0.5
    assert max(size for size, file in zip(sizes, files, strict=True) if file != "p2.csv") < 1e-6


def test_without_a_file_the_others_stay():
    rest = leave_out(Measured("", {}, (run(1), run(2), run(3)), "valve"), ["p2.csv"])
    assert [each.file for each in rest.runs] == ["p1.csv", "p3.csv"]
