"""Plausibility of a cylinder's records: each check fires on its fault, and none on honest data."""

import itertools

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.estimation.parameters import DECLARED
from apesim.studies.measured import CYLINDER, Measured, MeasuredRun, read_measured
from apesim.studies.measured.plausibility import Kind, examine
from apesim.studies.measured.prediction import predict, run_of
from apesim.studies.measured.strokes import split_record
from apesim.valve.rig import RIG_EFFECTS
from tests.folders import ROOT
from tests.machines import AMBIENT, changed

MACHINE = changed(Machine(), {"rig.bore": 25.7e-3})
HONEST = {"effects.coulomb_friction.force": 5.0, "effects.seal_friction.coefficient": 6e-6}
LAWS = [effect.name for effect in RIG_EFFECTS if effect.sensor is None and not effect.tabulated]
KEYS = [key for key in DECLARED if key.split(".")[0] == "effects" and key.split(".")[1] in LAWS]


def ways(gauge=2e5, machine=None, **changes):
    """The ways to and fro of a record of 20 s, with a noise of 0.2 N, and changed columns."""
    times = np.arange(0.0, 20.0, 0.01)
    stroke = 40e-3 * (1.0 - abs(1.0 - 2.0 * ((times / 8.0 + 0.125) % 1.0)))
    given = {"stroke": stroke, "pressure": np.full(len(times), AMBIENT + gauge)}
    moved = given | {"velocity": np.where(np.gradient(stroke) > 0.0, 0.01, -0.01)}
    run = MeasuredRun(
        "a", "a.csv", AMBIENT + gauge, 293.0, np.nan, "fit", times, {"force": times}, CYLINDER, given=moved
    )
    force = predict(run_of(machine or changed(MACHINE, HONEST), run), run).channels["force"]
    force = force + np.random.default_rng(1).normal(0.0, 0.2, len(times))
    columns = {name: changes.get(name, lambda values: values)(values) for name, values in given.items()}
    channels = {"force": changes.get("force", lambda values: values)(force)}
    return split_record(run._replace(given=columns, channels=channels))


def find(runs):
    return examine(MACHINE, Measured("rig", {}, tuple(runs), CYLINDER)).findings


@pytest.mark.parametrize("gauge", [1e5, 7e5])
def test_an_honest_record_is_silent(gauge):
    assert find(ways(gauge)) == []


@pytest.mark.parametrize("ring", ["o", "x"])
def test_the_records_of_a_laboratory_have_no_fault(ring):
    folder = ROOT / f"docs/examples/data/cylinder_{ring}_ring"
    machine = Machine.load(folder / "machine.toml")
    findings = examine(machine, read_measured(folder, machine.ambient.pressure)).findings
    assert [finding for finding in findings if finding.kind == Kind.FAULT] == []


@pytest.mark.parametrize("key", KEYS)
def test_no_effect_is_called_a_fault(key):
    for end, gauge in itertools.product(DECLARED[key].ends, (1e5, 7e5)):
        findings = find(ways(gauge, changed(MACHINE, {key: end})))
        assert [finding for finding in findings if finding.kind == Kind.FAULT] == [], (end, gauge)


@pytest.mark.parametrize(
    ("column", "change", "check", "reason"),
    [
        ("stroke", lambda values: 40e-3 - values, "inverted", "does the stroke fall where the drive pushes?"),
        ("force", lambda values: -values, "level", "inverted?"),
        ("force", lambda values: values / 9.80665, "level", "kgf called N?"),
        ("force", lambda values: values * 1e-3, "level", "kN called N?"),
        ("pressure", lambda values: values - AMBIENT, "supply", "gauge called abs?"),
        ("pressure", lambda values: values * 0.1, "supply", "MPa called bar, or 10 times too small?"),
    ],
)
def test_a_column_that_cannot_be_one_is_a_fault_said_once(column, change, check, reason):
    (finding,) = find(ways(**{column: change}))
    assert finding.kind == Kind.FAULT
    assert (str(finding.check), finding.channel, finding.file) == (check, column, "a.csv")
    assert finding.reason == reason


def test_another_supply_is_warned_of():
    runs = [run._replace(supply=AMBIENT + 3.5e5) for run in ways()]
    (finding,) = find(runs)
    assert finding.kind == Kind.WARNING
    assert finding.seen == "lies at 200 kPa gauge, the supply is stated as 350 kPa gauge"
