"""Which numbers of a machine are uncertain, how far, and who says so."""

import numpy as np
import pytest
from scipy.stats import t

from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.quantities.uncertainties import Uncertainty
from apesim.studies.estimation.heavy_tails import FREEDOM, SLAB, find_pull
from apesim.studies.estimation.priors import BENCH_PRIORS, describe_priors, nuisances_of, priors_of
from apesim.studies.measured import ENGINE, VALVE, Measured, MeasuredRun

RELEASE = "valve.solenoid.release_dead_time"


def nuisances(machine):
    return {one.key: one for one in nuisances_of(machine, Measured("", {}, (), "valve"))}


def test_the_release_is_uncertain_by_itself_where_the_machine_gives_it():
    """Otherwise it moves with the dead time of energising."""
    assert RELEASE not in nuisances(Machine())
    apart = nuisances(Machine().with_(**{RELEASE: "2.3 ms"}))
    assert (apart[RELEASE].value(0.0), apart[RELEASE].value(1.0)) == (2.3e-3, 2.4e-3)
    assert set(apart) == {*nuisances(Machine()), RELEASE}


def measured(known_to, bench=VALVE):
    lift = MeasuredRun("", "", 0.5e6, 287.0, 0.03, "fit", np.zeros(3), {"lift": np.zeros(3)})
    return Measured("rig", {}, (lift,), bench, known_to=known_to)


SECOND_AREA = "engine.exhaust_2.effective_area"
TWO = Machine().with_(**{SECOND_AREA: "200 mm^2"})
"""Machine with a second exhaust valve."""


def test_the_second_exhaust_valve_is_uncertain_where_the_machine_has_it():
    default, two = ({one.key: one for one in priors_of(of, measured({}, ENGINE))} for of in (Machine(), TWO))
    assert set(two) - set(default) == {SECOND_AREA}
    assert {key: two[key] for key in default} == default
    second = {one.key: one for one in nuisances_of(TWO, measured({}, ENGINE))}[SECOND_AREA]
    assert second.value(1.0) == pytest.approx(210e-6)
    assert SECOND_AREA not in nuisances(TWO)  # on the valve's bench


def test_how_far_the_second_exhaust_valve_is_known_can_be_stated():
    stated = {SECOND_AREA: Uncertainty(0.02, is_share=True), "engine.exhaust_2.opens": Uncertainty(0.01)}
    rows = {row["key"]: row for row in describe_priors(TWO, measured(stated, ENGINE))}
    assert [rows[key]["stated_in"] for key in stated] == ["measured.toml"] * 2
    assert rows[SECOND_AREA]["known_to"] == "2 %"


def test_what_the_machine_file_states_of_a_second_exhaust_valve_that_is_off_is_passed_over():
    off = Machine().with_(known_to={SECOND_AREA: "5 mm^2", "engine.exhaust_2.opens": "1 deg"})
    assert priors_of(off, measured({}, ENGINE)) == priors_of(Machine(), measured({}, ENGINE))
    with pytest.raises(InputError, match="is of a second exhaust valve that is off"):  # a share of nothing
        Machine().with_(known_to={SECOND_AREA: "5 %"})


def test_what_is_stated_takes_the_place_of_the_default():
    stated = {
        "valve.solenoid.dead_time": Uncertainty(0.02e-3),
        "effects.sensor_gain.lift": Uncertainty(0.001),
        "valve.stroke": Uncertainty(0.01, is_share=True),
    }
    default, known = (
        {one.key: one for one in nuisances_of(Machine(), measured(known_to))} for known_to in ({}, stated)
    )
    assert list(known) == [*default, "valve.stroke"]
    assert [known[key].scale for key in stated] == [0.02e-3, 0.001, 0.01]
    assert known["valve.stroke"].value(1.0) == pytest.approx(1.01 * 9e-3)
    same = default.keys() - stated.keys()
    assert {key: known[key] for key in same} == {key: default[key] for key in same}


def test_what_is_exact_is_no_nuisance():
    known = nuisances_of(Machine(), measured({"supply.pressure": Uncertainty(0.0)}))
    assert "supply.pressure" not in [one.key for one in known]
    assert len(known) == len(nuisances_of(Machine(), measured({}))) - 1


def test_each_row_says_who_states_it_and_why():
    stated = {"supply.pressure": Uncertainty(0.005, is_share=True), "valve.stroke": Uncertainty(0.0)}
    rows = {row["key"]: row for row in describe_priors(Machine(), measured(stated))}
    told = [(row["known_to"], row["stated_in"], row["reason"], row["value"]) for row in rows.values()]
    assert told[list(rows).index("supply.pressure")] == ("0.5 %", "measured.toml", "", None)
    assert told[list(rows).index("valve.stroke")] == ("exact", "measured.toml", "", pytest.approx(9.0))
    assert rows["sensor.lift.gain"]["known_to"] == "0.5 %"
    assert rows["sensor.lift.offset"]["known_to"] == "0.02 mm"
    assert {row["stated_in"] for row in rows.values()} == {"measured.toml", "default"}
    assert "sensor.pressure_a.gain" not in rows


def test_every_default_has_its_reason():
    assert all(prior.reason for priors in BENCH_PRIORS.values() for prior in priors)


OFF_VALVE = (
    "is of a second exhaust valve that is off; "
    "switch it on by engine.exhaust_2.effective_area in the machine file, or leave it out"
)


@pytest.mark.parametrize(
    ("key", "bench", "wrong"),
    [
        (RELEASE, VALVE, "the machine gives it no value; give it one, or leave it out here"),
        ("engine.receiver.volume", ENGINE, "the machine gives it the value inf; give it one, or leave it out here"),
        ("engine.pin_offset", ENGINE, "is a share of 0; write a number of mm"),
        (SECOND_AREA, ENGINE, OFF_VALVE),
        ("engine.exhaust_2.opens", ENGINE, OFF_VALVE),
        ("groove.ports.diameter", ENGINE, 'is ignored: groove.geometry is "line"; leave it out'),
        (
            "effects.side_force.force",
            VALVE,
            "is of an effect that is off; switch side_force on in the machine file, or leave it out",
        ),
    ],
)
def test_a_number_that_the_machine_does_not_have_is_refused(key, bench, wrong):
    machine = Machine().with_(engine_receiver_volume="inf")
    with pytest.raises(InputError) as caught:
        nuisances_of(machine, measured({key: Uncertainty(0.01, is_share=True)}, bench))
    assert str(caught.value) == f"rig/measured.toml: known_to.{key}: {wrong}"


def test_an_effect_that_is_on_may_be_known_within_a_prior():
    machine = Machine().with_(**{"effects.side_force.force": "3 N"})
    known = {one.key: one for one in nuisances_of(machine, measured({"effects.side_force.force": Uncertainty(0.5)}))}
    assert known["effects.side_force.force"].value(2.0) == pytest.approx(4.0)


def test_the_machine_file_goes_before_the_default_and_measured_toml_before_both():
    machine = Machine().with_(known_to={"valve.stroke": "1 %", "supply.pressure": "2 %", "engine.bore": "1 mm"})
    folder = measured({"supply.pressure": Uncertainty(0.005, is_share=True)})
    rows = {row["key"]: (row["known_to"], row["stated_in"]) for row in describe_priors(machine, folder)}
    assert rows["valve.stroke"] == ("1 %", "machine file")
    assert rows["supply.pressure"] == ("0.5 %", "measured.toml")
    assert rows["valve.viscous_friction"] == ("10 %", "default")
    assert "engine.bore" not in rows  # which the valve's bench does not depend on
    assert "engine.bore" in [row["key"] for row in describe_priors(machine, measured({}, ENGINE))]


def test_what_the_machine_file_states_of_an_effect_that_is_off_is_passed_over():
    stated = Machine().with_(known_to={"effects.side_force.force": "0.5 N"})
    assert nuisances_of(stated, measured({})) == nuisances_of(Machine(), measured({}))
    on = [one.key for one in nuisances_of(stated.with_(**{"effects.side_force.force": "3 N"}), measured({}))]
    assert "effects.side_force.force" in on


def test_a_pull_squared_is_twice_the_negative_log_likelihood_of_students_t_and_a_wide_normal_law():
    x = np.array([-30.0, -6.0, -1.0, 0.1, 2.0, 5.0])
    law = t(FREEDOM, scale=np.sqrt((FREEDOM + 1.0) / FREEDOM))
    far = -2.0 * (law.logpdf(x) - law.logpdf(0.0))
    assert find_pull(x) ** 2 == pytest.approx((1.0 - SLAB**-2) * far + (x / SLAB) ** 2)
    assert np.sign(find_pull(x)) == pytest.approx(np.sign(x))
    assert find_pull(1e-3) == pytest.approx(1e-3, rel=1e-6)  # near its middle a normal number's
