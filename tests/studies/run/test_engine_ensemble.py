"""An ensemble is what each machine gives alone, to the bit, whatever is run beside it."""

import numpy as np
import pytest

import apesim
from apesim.engine.drivetrain import point
from apesim.engine.indicators import COUNTS, FLAGS, INDICATORS
from apesim.engine.machine import Machine
from apesim.march.adaptive import Status
from apesim.quantities.input_errors import InputError
from apesim.results import name_of
from apesim.studies.run.engine_ensemble import run_many

MACHINES = [
    Machine(),
    Machine().with_(engine_bore="90 mm", valve_stroke="8 mm"),
    Machine().with_(supply_pressure="0.8 MPa gauge", ambient_pressure="90 kPa abs", command_release="60 deg"),
    Machine().with_(engine_intake="cam", groove_lap="1.5 mm"),
]
SPEEDS = np.array([1000, 900, 1200.5, 777])


@pytest.fixture(scope="module")
def many():
    return run_many(MACHINES, (SPEEDS, "rpm"))


def test_each_number_is_that_of_its_machine_alone(many):
    for number, (machine, speed) in enumerate(zip(MACHINES, SPEEDS, strict=True)):
        alone = apesim.run_engine(machine, (speed, "rpm"))
        for key, (unit, long_name) in INDICATORS.items():
            trace = many.traces[name_of(key, unit)]
            assert np.array_equal(trace[number], alone[key], equal_nan=key not in (*FLAGS, *COUNTS)), key
            assert (trace.dims, trace.unit, trace.long_name) == (("run",), unit, long_name)
        assert many.run_warnings[number] == alone.warnings
    assert many["runs"] == many["converged_runs"] == 4 and many.converged
    assert many.conditions == {"speed": "777 to 1200.5 r/min"}


def test_threads_give_the_same_and_report_each_point(many):
    told = []
    again = run_many(
        iter(MACHINES), [f"{speed} rpm" for speed in SPEEDS], jobs=3, progress=lambda *done: told.append(done)
    )
    assert again == many and told == [(done, 4) for done in (1, 2, 3, 4)]


def test_one_speed_is_that_of_all():
    both = run_many(MACHINES[:2], "1000 rpm")
    assert both.traces["speed_rpm"].values.tolist() == [1000.0, 1000.0]
    assert both.to_pandas()["brake_torque"].tolist() == both.traces["brake_torque"].values.tolist()


def test_a_march_that_ends_early_or_does_not_repeat_stops_no_other(monkeypatch):
    status = next(status for status in Status if status != Status.DONE)
    marches = {}

    def run_some(machine, speed, **options):
        run = marches.setdefault(machine.engine.bore, run_steady(machine, speed, max_cycles=40))
        if machine is MACHINES[1]:
            return run._replace(status=int(status))
        return run._replace(orbit=run.orbit._replace(converged=False)) if machine is MACHINES[2] else run

    run_steady = point.run_steady
    monkeypatch.setattr(point, "run_steady", run_some)
    found = run_many(MACHINES[:3], "1000 rpm")
    assert found.traces["converged"].values.tolist() == [True, False, False]
    assert np.isnan(found.traces["brake_torque"]).tolist() == [False, True, False]
    assert found.traces["cycles"][1] == 0 and not found.converged and found["converged_runs"] == 1
    assert "ended early" in found.run_warnings[1][0] and "not periodic" in found.run_warnings[2][0]
    assert [text[:6] for text in found.warnings] == ["run 1:", "run 2:"]


def test_an_error_of_a_point_ends_the_call_and_no_other_point_is_begun(monkeypatch):
    begun = []

    def fail(machine, speed, **options):
        begun.append(machine)
        raise KeyboardInterrupt

    monkeypatch.setattr(point, "run_steady", fail)
    with pytest.raises(KeyboardInterrupt):
        run_many(MACHINES, "1000 rpm")
    assert begun == MACHINES[:1]


@pytest.mark.parametrize(
    ("machines", "speed", "key", "right"),
    [
        ([], "1000 rpm", "machines", "give at least one Machine"),
        (Machine(), "1000 rpm", "machines", "write a list of Machines"),
        ("mine.toml", "1000 rpm", "machines", "write a list of Machines"),
        ([Machine(), 5], "1000 rpm", "machines", "write a list of Machines"),
        (iter([Machine(), 5]), "1000 rpm", "machines[1].machine", "give a Machine"),
        (MACHINES, "1000, 900, 800 rpm", "speed", "give one for all machines, or one for each of them"),
        (MACHINES, 1000, "speed", 'write e.g. "1000 rpm" or "1000 rad/s"'),
        (MACHINES, None, "speed", "write a value with its unit"),
    ],
)
def test_what_is_no_ensemble_is_refused_by_the_name_of_the_argument(machines, speed, key, right):
    with pytest.raises(InputError) as caught:
        run_many(machines, speed)
    (fault,) = caught.value.faults
    assert (fault.file, fault.key, fault.right) == ("run_many()", key, right)


def test_a_machine_that_no_file_could_say_is_refused_by_its_place_and_key():
    odd = Machine()._replace(valve=Machine().valve._replace(stroke=8.0))
    with pytest.raises(InputError, match=r"run_many\(\): machines\[1\].valve.stroke: 8000 mm is out of range"):
        run_many([Machine(), odd], "1000 rpm")
