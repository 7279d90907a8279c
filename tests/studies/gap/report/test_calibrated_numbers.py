"""The machine that a verdict leads to is the one that was judged; what belongs to sensors stands beside it."""

import tomllib
from types import SimpleNamespace

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.estimation.priors import Prior, nuisance
from apesim.studies.gap.report.calibrated_numbers import (
    apply_numbers,
    describe_value,
    find_calibrated_numbers,
    format_after,
    format_before,
    write_readings,
)
from apesim.studies.gap.report.extended_machine import extend_machine, write_sensors
from tests.machines import machine
from tests.studies.gap.report.test_verdict_json import GAUGE, RUNS, THERMOMETER, fitted

FRICTION = Prior("valve.viscous_friction", 0.10, True)
OFFSET, ZERO = Prior("effects.sensor_offset.lift", 0.02e-3), Prior("effects.tdc_error.angle", 1e-3)
PRIORS = (FRICTION, GAUGE, THERMOMETER, OFFSET, ZERO)
X = (1.5, 2.0, -1.0, 0.5, -2.0)


def model_of(runs=RUNS, x=X):
    """A machine that was calibrated, without anything added."""
    return fitted(machine(), runs, [nuisance(machine(), prior) for prior in PRIORS], x)


def explanation_of(model):
    calibrated = SimpleNamespace(residuals=SimpleNamespace(machine=machine()))
    return SimpleNamespace(calibrated=calibrated, best=model, tabulated=None, rest=None)


def data_of(verdict):
    data = {"verdict": verdict, "sentence": "", "effects": [], "numbers": [], "gap": {"before": 1.0}, "held_out": None}
    return data | {"p_value": 0.5, "lineage": {}}


def test_the_machines_numbers_are_written_and_those_of_the_laboratory_are_not(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(extend_machine(explanation_of(model_of()), data_of("NO_GAP"), tmp_path))
    child, parent = Machine.load(path), machine()
    assert child.valve.viscous_friction == pytest.approx(1.15 * parent.valve.viscous_friction, rel=1e-12)
    assert child.effects == parent.effects and child.supply == parent.supply
    lines = path.read_text().splitlines()
    place = lines.index("# calibrated; before: 111.08 N s/m; pull +1.50 prior sigmas")
    assert lines[place + 1].startswith("viscous_friction = ")
    assert sum(line.startswith("# calibrated; ") for line in lines) == 1


def test_what_sensors_read_too_much_stands_in_tables_that_a_machine_file_takes(tmp_path):
    path = tmp_path / "sensors.toml"
    path.write_text(write_sensors(explanation_of(model_of()), data_of("NO_GAP")))
    effects = Machine.load(path).effects
    assert effects.sensor_offset.lift == pytest.approx(0.01e-3)
    assert effects.tdc_error.angle == pytest.approx(-2e-3)
    # A supply that is 2 % higher than its gauge says, and 2 K colder than its thermometer.
    assert effects.sensor_gain.supply_pressure == pytest.approx(1.0 / 1.02 - 1.0)
    assert effects.sensor_offset.supply_temperature == pytest.approx(2.0)
    assert "pull -2.00 prior sigmas\nsupply_pressure" in path.read_text()
    assert "viscous" not in path.read_text()


def test_a_machine_that_lacks_something_keeps_its_numbers(tmp_path):
    text = extend_machine(explanation_of(model_of()), data_of("AMBIGUOUS"), tmp_path)
    assert tomllib.loads(text)["valve"]["viscous_friction"] == "111.08 N s/m"
    assert "# calibrated;" not in text and "numbers as they were" in text
    assert write_sensors(explanation_of(model_of()), data_of("AMBIGUOUS")) == ""


def test_a_supply_temperature_is_the_machines_where_a_run_does_not_state_it():
    silent = model_of([RUNS[0], RUNS[1]._replace(temperature=np.nan)])
    assert apply_numbers(machine(), find_calibrated_numbers(silent)).supply.temperature == pytest.approx(
        machine().supply.temperature - 2.0
    )
    assert "supply_temperature" in write_readings(machine(), find_calibrated_numbers(silent))


def test_numbers_on_which_the_data_do_not_depend_stay_as_they_are():
    assert find_calibrated_numbers(model_of(x=[1e-9] * len(X))) == []


@pytest.mark.parametrize(
    ("prior", "x", "before", "after"),
    [
        (FRICTION, 1.0, "111.08 N s/m", "122 N s/m"),
        (GAUGE, 0.8, "as each run states", "that +0.8 %"),
        (THERMOMETER, -0.5, "as each run states", "that -1.0 K"),
    ],
)
def test_a_number_that_runs_state_is_shown_as_its_shift(prior, x, before, after):
    row = describe_value(machine(), nuisance(machine(), prior), x, RUNS, deviation=0.1)
    assert (format_before(row), format_after(row)) == (before, after)
