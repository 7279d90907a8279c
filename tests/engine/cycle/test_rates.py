"""The coupled cycle: its rates against balances written out by hand, the columns of its trace against one another."""

from math import pi, sqrt

import numpy as np
import pytest

from apesim.engine.angles import DEGREE
from apesim.engine.cam import raised_cosine
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cycle.gas_exchange import start_exchange_segment
from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
from apesim.engine.cycle.rates import cycle_rates, handle_cycle_event, start_cycle_segment
from apesim.engine.cycle.state import (
    CYLINDER,
    EXCHANGE,
    EXHAUST,
    FEED,
    GROOVE,
    RECEIVER,
    control_ledger,
    cylinder_gas,
    effects_ledger,
    engine_ledger,
    instant_at,
    receiver_gas,
    supply_of,
)
from apesim.engine.kinematics import cylinder_volume
from apesim.restriction import CHOKED, SHUT
from apesim.valve.actuator import AREA, AREA_SLOPE, PHASE, PIECE, PIECE_HIGH, PIECE_LOW, REGIME, X_A, X_B, state_of
from apesim.valve.motion import CORNER
from apesim.valve.piston import TO_OPEN
from apesim.valve.solenoid_flow import start_solenoid_segment
from tests.machines import AMBIENT, RPM, machine, settled

R, K = 287.05, 1.4
CP, CV = K * R / (K - 1.0), R / (K - 1.0)
FINE = 0.05 * DEGREE


def flow(area, p_1, t_1, p_2, t_2):
    """Eqs. 7-8 as printed, and the enthalpy carried along."""
    if p_2 > p_1:
        mass, enthalpy = flow(area, p_2, t_2, p_1, t_1)
        return -mass, -enthalpy
    r = p_2 / p_1
    if r <= (2.0 / (K + 1.0)) ** (K / (K - 1.0)):
        psi = sqrt(K * (2.0 / (K + 1.0)) ** ((K + 1.0) / (K - 1.0)))
    else:
        psi = sqrt(2.0 * K / (K - 1.0) * (r ** (2.0 / K) - r ** ((K + 1.0) / K)))
    mass = area * psi * p_1 / sqrt(R * t_1)
    return mass, mass * CP * t_1


def state(a_machine, angle, cylinder, receiver, chambers=(0.6e6, 0.3e6), rpm=1000.0):
    """A machine's kernel view and a state with the valve half open and moving, and both solenoids half way.

    Pressures [Pa] and temperatures [K] of cylinder and receiver; the chambers' at 280 K.
    """
    p, _, _ = cycle_of(a_machine, rpm * RPM)
    y, mode = charged_at_rest(p)
    t = (angle * DEGREE - p.start) / p.speed
    volume = cylinder_volume(p.crank, angle * DEGREE)[0]
    y[0], y[1] = 4e-3, -0.7
    v_a, v_b = 11382e-9 + 1134.1e-6 * 4e-3, 11382e-9 + 1134.1e-6 * 5e-3
    for i, (pressure, temperature, v) in (
        (2, (chambers[0], 280.0, v_a)),
        (4, (chambers[1], 280.0, v_b)),
        (CYLINDER, (*cylinder, volume)),
        (RECEIVER, (*receiver, p.receiver_volume)),
    ):
        y[i], y[i + 1] = pressure * v / (R * temperature), pressure * v / (K - 1.0)
    mode[PHASE] = TO_OPEN
    mode[AREA], mode[AREA_SLOPE] = -150e-6 / 8.0, 150e-6 / 8e-3
    mode[X_A], mode[X_B] = 0.5, 0.25
    now = instant_at(p, t, y)
    valve = state_of(p.actuator, y, supply_of(p, y, now.receiver))
    start_solenoid_segment(valve, (1.0,) * 4, (1.0,) * 4, REGIME, mode)
    start_exchange_segment(p, now, p.start + p.speed * t, y, mode)
    dy = np.empty_like(y)
    assert cycle_rates(p, t, y, mode, dy)
    return p, dy


CASES = {
    "admission, choked": (40.0, (0.2e6, 250.0), (1.0e6, 290.0)),
    "admission": (40.0, (0.9e6, 300.0), (1.0e6, 290.0)),
    "back-flow into the receiver": (-20.0, (1.6e6, 400.0), (1.2e6, 290.0)),
    "exhaust, choked": (200.0, (0.5e6, 240.0), (1.0e6, 290.0)),
    "exhaust": (250.0, (0.13e6, 260.0), (1.0e6, 290.0)),
    "back-flow from outside": (170.0, (0.06e6, 200.0), (1.0e6, 290.0)),
}


@pytest.mark.parametrize("control_air", ["regulator", "receiver"])
@pytest.mark.parametrize("case", CASES)
def test_rates_of_cylinder_and_receiver_are_the_first_law_of_each_flow(case, control_air):
    angle, cylinder, receiver = CASES[case]
    p, dy = state(machine(receiver=1.0, control_air=control_air), angle, cylinder, receiver)
    lift_area = 150e-6 * (5e-3 - 1e-3) / 8e-3
    valve = p.engine.exhaust
    exhaust_area = valve.effective_area * raised_cosine(angle * DEGREE, valve.opens, valve.closes, valve.flank)
    groove, groove_enthalpy = flow(lift_area, *receiver, *cylinder)
    out, out_enthalpy = flow(exhaust_area, *cylinder, AMBIENT, 293.15) if exhaust_area else (0.0, 0.0)
    fed, fed_enthalpy = flow(200e-6, 1.101325e6, 287.0, *receiver)
    control = receiver if control_air == "receiver" else (1.101325e6, 287.0)
    into_a, into_b = flow(4.5e-6, *control, 0.6e6, 280.0), flow(2.25e-6, *control, 0.3e6, 280.0)
    drawn, drawn_enthalpy = (into_a[0] + into_b[0], into_a[1] + into_b[1]) if control_air == "receiver" else (0.0, 0.0)
    slope = cylinder_volume(p.crank, angle * DEGREE)[1]
    cylinder_rates = groove - out, groove_enthalpy - out_enthalpy - cylinder[0] * slope * p.speed
    receiver_rates = fed - groove - drawn, fed_enthalpy - groove_enthalpy - drawn_enthalpy
    assert cylinder_gas(dy) == pytest.approx(cylinder_rates, rel=1e-11, abs=1e-13)
    assert receiver_gas(dy) == pytest.approx(receiver_rates, rel=1e-11, abs=1e-13)
    expected = {
        "groove": (groove, groove_enthalpy),
        "groove_back": max(0.0, -groove),
        "exhaust": (out, out_enthalpy),
        "exhaust_back": max(0.0, -out),
        "feed": (fed, fed_enthalpy),
        "pipe": (0.0, 0.0),
        "supplied": (into_a[0] + into_b[0], into_a[1] + into_b[1]),
        "work": cylinder[0] * slope * p.speed,
    }
    engine = engine_ledger(dy)
    ledgers = engine._asdict() | control_ledger(dy)._asdict()
    for name, value in expected.items():
        assert ledgers[name] == pytest.approx(value, rel=1e-11, abs=1e-13), name


@pytest.mark.parametrize("case", CASES)
def test_what_one_volume_loses_another_one_gets(case):
    """Over all volumes, flows between them cancel; with every effect of the cylinder on."""
    a_machine = machine(
        receiver=1.0,
        control_air="receiver",
        effects__blow_by__area=0.5e-6,
        effects__cylinder_wall_heat__h=200.0,
        effects__ring_leakage__area=0.2e-6,
    )
    _, dy = state(a_machine, *CASES[case])
    mass = dy[[2, 4, CYLINDER, RECEIVER]].sum()
    energy = dy[[3, 5, CYLINDER + 1, RECEIVER + 1]].sum()
    vented, engine, let_in = control_ledger(dy).vented, engine_ledger(dy), effects_ledger(dy)
    fed, out = engine.feed, engine.exhaust
    assert mass == pytest.approx(fed.mass - out.mass - vented.mass + let_in.mass, abs=1e-14)
    entered = fed.enthalpy - out.enthalpy - vented.enthalpy + let_in.enthalpy
    assert energy == pytest.approx(entered - engine.work - control_ledger(dy).valve_work, abs=1e-8)


def test_where_the_groove_begins_to_open_as_the_exhaust_does_the_exhaust_stays_open():
    p, tables, breakpoints = cycle_of(machine(receiver=1.0), 1000.0 * RPM)
    y, mode = charged_at_rest(p)
    y[0], y[1], mode[PHASE] = 8e-3, -0.7, TO_OPEN
    opens = p.engine.exhaust.opens
    y[CYLINDER : CYLINDER + 2] *= 5.0 * cylinder_volume(p.crank, opens)[0] / cylinder_volume(p.crank, p.start)[0]
    t = (opens - p.start) / p.speed
    start_cycle_segment(p, tables, t, breakpoints[breakpoints > t + 1e-9][0], y, mode)
    mode[PIECE], mode[EXCHANGE + GROOVE] = 0.0, SHUT
    mode[PIECE_LOW], mode[PIECE_HIGH] = -np.inf, p.actuator.valve.stroke - 8e-3
    before = mode.copy()
    assert before[EXCHANGE + EXHAUST] == CHOKED
    handle_cycle_event(p, tables, CORNER, t, y, mode)
    assert mode[EXCHANGE + GROOVE] != SHUT
    assert mode[EXCHANGE + EXHAUST] == before[EXCHANGE + EXHAUST]
    assert mode[EXCHANGE + FEED] == before[EXCHANGE + FEED]


def test_a_cylinder_without_gas_is_out_of_the_domain():
    p, _, _ = cycle_of(machine(), 1000.0 * RPM)
    y, mode = charged_at_rest(p)
    dy = np.empty_like(y)
    assert cycle_rates(p, 0.0, y, mode, dy)
    for index in (CYLINDER, CYLINDER + 1):
        empty = y.copy()
        empty[index] = 0.0
        assert not cycle_rates(p, 0.0, empty, mode, dy)


@pytest.fixture(scope="module", params=["epv", "cam", "ideal"])
def traced(request):
    """A settled run with a fine trace, and the trace's columns by name, without units."""
    run = settled(machine(intake=request.param, receiver=1.0), 800.0, angle_step=FINE)
    return run, {name.split(" [")[0]: run.trace[:, i] for i, name in enumerate(TRACE)}


def over_time(run, column):
    return np.trapezoid(column, (run.angles - run.cycle.start) / run.cycle.speed)


def test_torque_is_the_pressure_above_ambient_on_the_volume_s_slope(traced):
    run, column = traced
    slope = np.array([cylinder_volume(run.cycle.crank, angle)[1] for angle in run.angles])
    assert column["torque"] == pytest.approx((column["cylinder_pressure"] - AMBIENT) * slope, rel=1e-12, abs=1e-9)


def test_torque_and_flows_integrate_to_the_ledger(traced):
    """Trapezia of 0.05 degrees: an error of second order, and of a jump of the ideal valve half a step of its flow."""
    run, column = traced
    jump = column["groove_flow"].max() * FINE / run.cycle.speed if run.cycle.engine.intake == 2 else 0.0
    ledger = engine_ledger(run.end)
    assert np.trapezoid(column["torque"], run.angles) == pytest.approx(ledger.work, rel=1e-4)
    assert over_time(run, column["groove_flow"]) == pytest.approx(ledger.groove.mass, rel=1e-4, abs=jump)
    assert over_time(run, column["exhaust_flow"]) == pytest.approx(ledger.exhaust.mass, rel=1e-4)


def test_pressure_temperature_and_volume_hold_the_cylinder_s_gas(traced):
    """Mass from the ideal gas law is what the flows of the trace have brought in."""
    run, column = traced
    mass = column["cylinder_pressure"] * column["cylinder_volume"] / (R * column["cylinder_temperature"])
    assert mass[0] == pytest.approx(run.start[CYLINDER], rel=1e-12)
    net = column["groove_flow"] - column["exhaust_flow"]
    steps = 0.5 * (net[1:] + net[:-1]) * FINE / run.cycle.speed
    jump = 2.0 * abs(net).max() * FINE / run.cycle.speed
    assert mass == pytest.approx(mass[0] + np.append(0.0, np.cumsum(steps)), abs=jump)
    volumes = [cylinder_volume(run.cycle.crank, angle)[0] for angle in run.angles]
    assert column["cylinder_volume"] == pytest.approx(volumes, rel=1e-12)


def test_the_trace_begins_where_it_ends(traced):
    run, column = traced
    for name in ("cylinder_pressure", "cylinder_temperature", "cylinder_volume", "receiver_pressure"):
        assert column[name][-1] == pytest.approx(column[name][0], rel=1e-5), name
    assert run.angles[-1] - run.angles[0] == pytest.approx(2.0 * pi, rel=1e-12)


def test_velocity_is_the_slope_of_the_lift(traced):
    run, column = traced
    if run.cycle.engine.intake != 0:
        assert np.isnan(column["velocity"]).all()
        return
    step = FINE / run.cycle.speed
    slope = (column["lift"][2:] - column["lift"][:-2]) / (2.0 * step)
    contacts = np.abs(np.diff(column["velocity"], 2)) > 0.1
    near_contact = np.convolve(contacts, np.ones(5), "same") > 0.0
    assert slope[~near_contact] == pytest.approx(column["velocity"][1:-1][~near_contact], abs=5e-3)
    assert column["lift"].min() == pytest.approx(0.0, abs=1e-12)
    assert column["lift"].max() == pytest.approx(9e-3, abs=1e-12)
    assert column["velocity"].max() > 1.0
    assert column["velocity"].min() < -1.0
