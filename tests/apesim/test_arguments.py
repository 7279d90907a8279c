"""What a public function is called with: speeds and angles have their unit, and a wrong type is refused by its name."""

import inspect
from fractions import Fraction
from types import NoneType
from typing import get_args

import numpy as np
import pytest

import apesim
from apesim.engine.angles import DEGREE
from apesim.engine.machine import Machine
from apesim.quantities import Quantity
from apesim.quantities.arguments import WithUnit, values_of
from apesim.quantities.settings import schema
from apesim.studies.run.operating_conditions import DURATION, PRESSURE, SPEED

FUNCTIONS = [getattr(apesim, name) for name in apesim.__all__ if name.islower()]
NEEDED = {
    "machine": Machine(),
    "machines": [Machine()],
    "model": "valve",
    "speed": "900 rpm",
    "measured": "no folder",
    "files": ["no.csv"],
    "paths": ["no.h5"],
    "volume": "50 cm^3",
    "free": ["valve.stroke"],
}
"""Arguments that functions cannot do without; all others have a default, or are paths."""
TURNING = [
    (apesim.run_engine, "speed"),
    (apesim.run_many, "speed"),
    (apesim.export_fmu, "speed"),
    (apesim.sweep, "speed"),
    (apesim.assess_valve, "speed"),
    (apesim.correct_timing, "speed"),
    (apesim.correct_timing, "target"),
    (apesim.optimise_commands, "speed"),
    (apesim.find_engine_limit, "duration"),
    (apesim.start_engine, "angle"),
    (apesim.start_engine, "until"),
    (apesim.start_engine, "cranking_release"),
    (apesim.run_transient, "angle"),
    (apesim.run_transient, "from_speed"),
    (apesim.design_machine, "rated_speed"),
    (apesim.explore, "speed"),
]
"""Arguments that are speeds or angles."""
SPEEDS = "speed", "until", "from_speed", "rated_speed"
"""Names of those that are speeds."""
SINGLE = (
    *(apesim.run_engine, apesim.start_engine, apesim.run_transient, apesim.design_machine),
    *(apesim.explore, apesim.export_fmu),
)
"""Functions that take one value of each."""
BARE = [600, 600.0, np.float64(600.0), np.float32(600), np.int64(600), np.array(600), Fraction(600)]
BARE_LISTS = [[600, 1000], (600.0, 1000.0), np.arange(600, 1801, 200), [np.float64(60.0)], range(9), ["60 deg", 70]]


def refused(function, **given):
    """Fault of a call with one wrong argument; a file that is not there may have one of its own."""
    parameters = inspect.signature(function).parameters.values()
    needed = {p.name: NEEDED.get(p.name, "no") for p in parameters if p.default is p.empty}
    with pytest.raises(apesim.InputError) as caught:
        function(**needed | given)
    [fault] = [fault for fault in caught.value.faults if not fault.file.startswith("no")]
    assert fault.file.startswith(f"{function.__name__}()") and "\n" not in str(fault)
    return fault


def arguments_of_all():
    return [(function, parameter) for function in FUNCTIONS for parameter in inspect.signature(function).parameters]


def names(pairs):
    return [f"{function.__name__}-{name}" for function, name in pairs]


@pytest.mark.parametrize(("function", "name"), TURNING, ids=names(TURNING))
def test_a_speed_or_an_angle_without_its_unit_is_refused(function, name):
    takes_list = function not in SINGLE
    for given in BARE + BARE_LISTS * takes_list:
        fault = refused(function, **{name: given})
        assert fault.key == name and "has no unit" in fault.wrong
        assert ("rpm" if name in SPEEDS else "deg") in fault.right and "rad" in fault.right


def test_no_argument_that_is_a_speed_or_an_angle_is_forgotten():
    """They alone are annotated as what has a unit and is no float."""
    found = []
    for function, name in arguments_of_all():
        members = get_args(inspect.signature(function).parameters[name].annotation)
        if set(get_args(WithUnit)) <= set(members) and float not in members:
            found.append((function, name))
    assert sorted(names(found)) == sorted(names(TURNING))


@pytest.mark.parametrize("leaf", [leaf for leaf in schema(Machine) if getattr(leaf.declaration, "unit", "") == "deg"])
def test_an_angle_of_the_machine_without_its_unit_is_refused(leaf):
    number = leaf.default / DEGREE + 0.01
    with pytest.raises(apesim.InputError, match=f"{leaf.key}: .* has no unit; write e.g. "):
        Machine().with_(**{leaf.key: leaf.default + 1e-4})
    if not leaf.key.startswith(("effects", "engine", "stage_2")):
        assert Machine().with_(**{leaf.key: (number, "deg")}) == Machine().with_(**{leaf.key: f"{number!r} deg"})
    with pytest.raises(apesim.InputError, match=r"sweep\(\): vary: .* has no unit"):
        apesim.sweep(Machine(), "600 rpm", vary={leaf.key: [leaf.default, leaf.default + 0.01]})


def test_numbers_with_their_unit_are_read_as_a_text_would_be():
    speeds = values_of("600:1800:200 rpm", SPEED)
    assert values_of((np.arange(600, 1801, 200), "rpm"), SPEED) == speeds
    assert values_of((list(range(600, 1801, 200)), "r/min"), SPEED) == speeds
    assert values_of(((600, Fraction(800)), "rpm"), SPEED) == values_of([(600, "rpm"), "800 rpm"], SPEED) == speeds[:2]
    assert values_of(("60 deg", "75 deg"), DURATION) == values_of(([60, 75.0], "deg"), DURATION)
    gauge = values_of(([0.4, 0.8], "MPa gauge"), PRESSURE, 101325.0)
    assert gauge == values_of("0.4 MPa gauge, 0.8 MPa gauge", PRESSURE, 101325.0)
    assert values_of([5e5, "0.8 MPa abs"], PRESSURE) == [5e5, 8e5]  # a number is in SI where that is beyond doubt
    assert Machine().with_(engine_bore=(9, "cm")).engine.bore == 0.09


@pytest.mark.parametrize(
    ("given", "wrong"),
    [
        (([600, None], "rpm"), "is no number and no list of numbers"),
        (([[600], [1, 2]], "rpm"), "is no number and no list of numbers"),
        (([True], "rpm"), "is no number and no list of numbers"),
        ((600, "mm"), "'mm' cannot be converted to rpm"),
        ((0.1, "rpm"), "out of range"),
        ((float("nan"), "rpm"), "no finite number"),
        (([], "rpm"), "is no list of 1 to"),
        (("600", "rpm"), "'600' has no unit"),
    ],
)
def test_numbers_with_a_wrong_unit_or_wrong_numbers_are_refused(given, wrong):
    with pytest.raises(apesim.InputError, match=wrong):
        values_of(given, SPEED)


def test_one_value_is_no_list():
    assert "is not one value" in refused(apesim.run_engine, speed=([600, 900], "rpm")).wrong


def is_optional(function, name):
    return NoneType in get_args(inspect.signature(function).parameters[name].annotation)


@pytest.mark.parametrize(("function", "name"), arguments_of_all(), ids=names(arguments_of_all()))
def test_none_and_wrong_types_are_refused_by_the_name_of_the_argument(function, name):
    wrong = [object(), 1j] if is_optional(function, name) else [None, object(), 1j]
    for given in wrong:
        fault = refused(function, **{name: given})
        assert fault.key == name and fault.wrong and fault.right


@pytest.mark.parametrize(
    ("function", "given"),
    [
        (apesim.fit, {"free": "valve.stroke"}),
        (apesim.explain, {"without": "ring_leakage"}),
        (apesim.evaluate_discharge, {"files": "p.csv"}),
        (apesim.merge_archives, {"paths": "a.h5"}),
        (apesim.merge_archives, {"paths": ["a.h5", 5]}),
        (apesim.sweep, {"vary": [5]}),
        (apesim.sweep, {"vary": {5: "80 mm"}}),
        (apesim.sweep, {"traces": "no"}),
        (apesim.sweep, {"intake": [None]}),
        (apesim.read_measured, {"ambient_pressure": "1 bar"}),
        (apesim.read_measured, {"bench": "car"}),
    ],
)
def test_what_is_nearly_right_is_refused_by_the_name_of_the_argument(function, given):
    fault = refused(function, **given)
    assert (fault.key or fault.file.rpartition(" ")[2]) in given


@pytest.mark.parametrize(("name", "wrong"), [("settings", 5), ("settings", [5]), ("path", 5)])
def test_a_machine_is_loaded_from_a_path_and_texts_alone(name, wrong):
    with pytest.raises((apesim.InputError, TypeError), match=name):
        Machine.load(**{name: wrong})


def test_numbers_of_any_kind_in_a_machine_become_floats():
    from apesim.studies.execution.calls import arguments_of

    curve = np.array([[0, 0], [1, 1]], dtype=np.float32)
    curve.flags.writeable = False
    odd = Machine()
    solenoid = odd.valve.solenoid._replace(dead_time=np.float32(0.002), opening_curve=curve)
    odd = odd._replace(
        valve=odd.valve._replace(stroke=Fraction(9, 1000), solenoid=solenoid),
        engine=odd.engine._replace(compression_ratio=10, intake=np.int8(1)),
        known_to=[],
    )
    _, good = arguments_of("run_engine", odd)
    for leaf in schema(Machine, good):
        kind = float if isinstance(leaf.declaration, Quantity) else (int, np.ndarray, tuple)
        assert isinstance(leaf.default, kind) and type(leaf.default) not in (np.float64, np.int8), leaf.key
    held = good.valve.solenoid.opening_curve
    assert held.dtype == float and held.flags.carray and good.engine.compression_ratio == 10.0
    assert odd.with_(engine_bore="90 mm").valve.stroke == 0.009  # by way of with_, too
    same = Machine().with_(engine_bore="90 mm")
    assert arguments_of("run_engine", same)[1] is same


@pytest.mark.parametrize("value", [None, True, "9 mm", [0.009], np.array([0.009]), 1j])
def test_what_is_no_number_in_a_machine_is_refused_by_its_key(value):
    odd = Machine()._replace(valve=Machine().valve._replace(stroke=value))
    assert refused(apesim.run_valve, machine=odd).key == "valve.stroke"
    assert refused(apesim.run_valve, machine=Machine()._replace(valve=value)).key == "valve"
