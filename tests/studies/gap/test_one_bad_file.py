"""One file whose record is wrong, among good ones, on data of the independent simulator."""

import pytest

from apesim.engine.machine import Machine
from apesim.studies.gap.workflow import explain
from apesim.studies.measured import read_measured
from tests.gap_bench import BUT_RIVALS
from tests.studies.gap.conftest import AMBIENT
from tests.truth.simulator.valve import Bench

FOUR = {0.16e6: "fit", 0.40e6: "fit", 0.70e6: "fit", 0.55e6: "fit", 0.49e6: "check"}


def explained(folder):
    return explain(Machine(), read_measured(folder, AMBIENT), without=BUT_RIVALS)


def slipped(columns):
    """The lift sensor slips by 8 standard deviations of the noise."""
    columns["lift [m]"] = columns["lift [m]"] + 0.24e-3


def stretched(columns):
    """The gain of the lift is 3 % too high."""
    columns["lift [m]"] = 1.03 * columns["lift [m]"]


def triggered_late(columns):
    columns["time [s]"] = columns["time [s]"] + 1e-3


def swapped(columns):
    first, second = "pressure_a [Pa abs]", "pressure_b [Pa abs]"
    columns[first], columns[second] = columns[second], columns[first]


def noted_wrong(columns):
    """The supply of 0.40 MPa is noted as 3 % more."""
    return 1.03 * 0.40e6


FAULTS = {
    slipped: ("run_offset", 0.24),
    stretched: ("run_gain", 0.03),
    triggered_late: ("run_time_zero", 1.0),
    swapped: ("run_swap", 1.0),
    noted_wrong: ("run_supply", 0.03),
}


@pytest.mark.parametrize(
    "spoilt", [slipped, *(pytest.param(each, marks=pytest.mark.slow) for each in list(FAULTS)[1:])]
)
def test_a_fault_of_one_file_is_found_and_the_rest_is_explained_without_it(measure, spoilt):
    found = explained(measure(Bench(), FOUR, spoilt=spoilt))
    kind, size = FAULTS[spoilt]
    assert found.verdict == "MEASUREMENT", found
    data = found.to_dict()
    assert data["files"] == ["1.csv"]
    (row,) = data["effects"]
    assert (row["name"], row["file"]) == (kind, "1.csv")
    low, high = row["interval_95"]
    assert low <= size <= high
    assert row["value"] == pytest.approx(size, rel=0.2)
    assert data["rest"]["verdict"] == "NO_GAP"
    assert "1.csv" in found.sentence
    assert "Without it, the model explains the data" in found.sentence
    assert data["next_test"]["text"] == "Record 1.csv again, or leave it out."


@pytest.mark.slow
def test_an_effect_beside_a_faulty_file_is_named_without_the_file(measure):
    found = explained(measure(Bench(dry_friction=3.0, breakaway=3.0), FOUR, spoilt=slipped))
    assert found.verdict == "MEASUREMENT", found
    assert found.to_dict()["files"] == ["1.csv"]
    assert [row["file"] for row in found.effects] == ["1.csv"]
    assert found.rest.verdict == "NAMED"
    assert [row["name"] for row in found.rest.effects][:1] == ["coulomb_friction"]
    child = found.rest.best.machine()
    assert child.effects.coulomb_friction.force == pytest.approx(3.0, rel=0.15)
    assert child.effects.sensor_offset.lift == 0.0


def test_a_spoilt_gate_is_not_passed_over(measure):
    """A run that nothing is fitted to contradicts the model: nothing is said to be explained."""
    gate_second = {0.16e6: "fit", 0.40e6: "gate", 0.70e6: "fit", 0.55e6: "fit"}
    found = explained(measure(Bench(), gate_second, spoilt=stretched))
    assert found.verdict == "REFUSED", found
    assert "1.csv" in found.reason
