"""Wall heat, blow-by and seat leak: nothing at strength zero, their laws by hand, ledgers, and which way they push."""

import numpy as np
import pytest

from apesim.air import GasState, gas_of
from apesim.effect import law
from apesim.engine.angles import DEGREE
from apesim.engine.cycle.cylinder_laws import BRANCHED, TRACE
from apesim.engine.cycle.operating_point import accuracy_at, cycle_of
from apesim.engine.cycle.state import STATES, effects_ledger
from apesim.engine.cylinder import ENERGY, GROOVE_ENERGY, GROOVE_MASS, MASS, TERMS, CylinderState
from apesim.engine.effects.blow_by import BlowBy
from apesim.engine.effects.cylinder_wall_heat import ANNAND, COMPRESSOR, HOHENBERG, WOSCHNI, CylinderWallHeat
from apesim.engine.effects.seat_leak import SeatLeak
from apesim.engine.indicators import indicators
from apesim.march.adaptive import LOG_HEAD, LOG_ROWS, NO_CARRY, march
from apesim.restriction import CHOKED
from tests.machines import AMBIENT, RPM, machine, settled

FINE = 0.05 * DEGREE
PISTON = 0.25 * np.pi * 0.085**2
SPEED = 1000.0 * RPM


def cylinder(pressure, temperature, volume):
    a_machine = machine()
    air, intake = GasState(pressure, temperature), GasState(1.1e6, 287.0)
    ambient = GasState(*a_machine.ambient)
    behind_exhaust = GasState(1.3e5, ambient.temperature)
    gas, engine = gas_of(a_machine.air), a_machine.engine
    return CylinderState(gas, ambient, engine, SPEED, 0.3, volume, air, intake, behind_exhaust)


def added(effect, pressure=5e5, temperature=280.0, volume=200e-6):
    balance = np.zeros(TERMS)
    law(effect, cylinder(pressure, temperature, volume), balance)
    return balance


def with_effects(**effects):
    """A machine with a receiver of 1 L, and effects."""
    a_machine = machine(receiver=1.0)
    return a_machine._replace(effects=a_machine.effects._replace(**effects))


IDLE = {
    "effects__cylinder_wall_heat__wall_temperature": 400.0,
    "effects__cylinder_wall_heat__correlation": ANNAND,
}


@pytest.mark.parametrize("on", [{}, {"effects__blow_by__area": 0.5e-6}])
@pytest.mark.compiled
def test_wall_heat_of_no_strength_changes_no_bit(on):
    plain, idle = (settled(machine(receiver=1.0, **values), 800.0) for values in (on, on | IDLE))
    assert np.array_equal(plain.end, idle.end)
    assert np.array_equal(plain.trace, idle.trace)


@pytest.mark.compiled
def test_blow_by_of_no_strength_changes_no_bit_where_another_effect_is_on():
    """All laws stand behind one guard: with wall heat on, that of blow-by is asked too."""
    heated = settled(machine(effects__cylinder_wall_heat__h=200.0), 800.0)
    assert np.array_equal(added(BlowBy(0.0)), np.zeros(TERMS))
    assert effects_ledger(heated.end).mass == 0.0
    assert effects_ledger(heated.end).enthalpy != 0.0


@pytest.mark.parametrize(
    ("correlation", "coefficient"),
    [
        pytest.param(WOSCHNI, 158.785, id="3.26 x 0.085^-0.2 x 500^0.8 x 280^-0.55 x 6.688^0.8"),
        pytest.param(HOHENBERG, 266.472, id="130 x 0.0002^-0.06 x 5^0.8 x 280^-0.4 x 4.3333^0.8"),
        pytest.param(ANNAND, 423.30, id="0.5 x 88648^0.7 x 0.024759/0.085"),
        pytest.param(COMPRESSOR, 114.15, id="0.053 x 88648^0.8 x 0.71^0.6 x 0.024759/0.085"),
    ],
)
def test_correlations_at_a_hand_computed_state(correlation, coefficient):
    """5 bar, 280 K, 200 cm3, bore 85 mm, 2.9333 m/s: 6.2209 kg/m3, Sutherland's 1.7497e-5 Pa s, 0.024759 W/(m K)."""
    area = 2.0 * PISTON + 4.0 * 200e-6 / 0.085
    heat = added(CylinderWallHeat(0.0, 1.0, correlation, 300.0))[ENERGY]
    assert heat / (area * 20.0) == pytest.approx(coefficient, rel=2e-5)


def test_a_constant_and_a_share_of_a_correlation_add_up():
    one, other, both = (
        added(CylinderWallHeat(*strengths, HOHENBERG, 300.0))[ENERGY]
        for strengths in ((50.0, 0.0), (0.0, 2.0), (50.0, 2.0))
    )
    assert one == pytest.approx(50.0 * (2.0 * PISTON + 4.0 * 200e-6 / 0.085) * 20.0, rel=1e-12)
    assert both == pytest.approx(one + other, rel=1e-12)


def test_heat_flows_from_hot_to_cold():
    wall = CylinderWallHeat(100.0, 1.0, WOSCHNI, 300.0)
    assert added(wall, temperature=299.0)[ENERGY] > 0.0 > added(wall, temperature=301.0)[ENERGY]
    assert added(wall, temperature=300.0)[ENERGY] == 0.0
    assert added(wall)[MASS] == 0.0


def test_blow_by_is_choked_flow_out_of_the_cylinder_with_its_enthalpy():
    """0.5 mm2 at 5 bar and 280 K: 0.68473 S p/sqrt(R T)."""
    mass, energy, *others, regime = added(BlowBy(0.5e-6))
    assert (others, regime) == ([0.0] * 4, CHOKED), "nothing past the groove, and no heat"
    assert mass == pytest.approx(-0.684731 * 0.5e-6 * 5e5 / np.sqrt(287.05 * 280.0), rel=1e-6)
    assert energy == pytest.approx(mass * 1004.675 * 280.0, rel=1e-9)


def test_blow_by_sucks_ambient_air_into_a_cylinder_below_ambient():
    mass, energy, *_ = added(BlowBy(0.5e-6), pressure=0.3 * AMBIENT, temperature=200.0)
    assert mass == pytest.approx(0.684731 * 0.5e-6 * AMBIENT / np.sqrt(287.05 * 293.15), rel=1e-6)
    assert energy == pytest.approx(mass * 1004.675 * 293.15, rel=1e-9)


def test_constant_wall_heat_is_the_integral_over_the_trace_and_adds_work():
    h, wall = 200.0, 300.0
    adiabatic = settled(machine(), 800.0)
    run = settled(machine(effects__cylinder_wall_heat__h=h), 800.0, angle_step=FINE)
    column = {name.split(" [")[0]: run.trace[:, i] for i, name in enumerate(TRACE)}
    area = 2.0 * PISTON + 4.0 * column["cylinder_volume"] / 0.085
    rate = h * area * (wall - column["cylinder_temperature"])
    heat = np.trapezoid(rate, run.angles) / run.cycle.speed
    assert effects_ledger(run.end).enthalpy == pytest.approx(heat, rel=1e-5)
    assert heat > 0.0
    assert adiabatic.end[-1] < run.end[-1] < adiabatic.end[-1] + heat


@pytest.mark.compiled
def test_blow_by_takes_mass_and_all_still_closes():
    tight = settled(machine(), 800.0)
    a_machine = machine(effects__blow_by__area=0.5e-6)
    run = settled(a_machine, 800.0)
    found = indicators(a_machine, run)
    assert effects_ledger(run.end).mass < 0.0
    assert run.end[-1] < tight.end[-1]
    assert found["engine_air_kg_per_cycle"] > indicators(machine(), tight)["engine_air_kg_per_cycle"]
    assert found["mass_closure"] < 1e-12
    assert found["energy_closure"] < 1e-11


@pytest.mark.parametrize("correlation", [WOSCHNI, HOHENBERG, ANNAND, COMPRESSOR])
@pytest.mark.compiled
def test_an_engine_runs_with_each_correlation(correlation):
    a_machine = machine(effects__cylinder_wall_heat__factor=1.0, effects__cylinder_wall_heat__correlation=correlation)
    run = settled(a_machine, 800.0)
    assert effects_ledger(run.end).enthalpy > 0.0
    assert indicators(a_machine, run)["energy_closure"] < 1e-11


@pytest.mark.parametrize("rpm", [400.0, 1000.0])
@pytest.mark.compiled
def test_blow_by_changes_over_at_an_event_and_the_work_converges(rpm):
    """From the same start, at the default tolerance; 25 tolerances were it stepped over."""
    a_machine = machine(receiver=1.0, effects__blow_by__area=1e-6)
    orbit = settled(a_machine, rpm, tolerance=1e-11).orbit
    p, tables, breakpoints = cycle_of(a_machine, rpm * RPM)
    ends, logs = [], []
    for tolerance in (1e-7, 1e-12):
        y, mode, log = orbit.y.copy(), orbit.mode.copy(), np.empty((LOG_ROWS, LOG_HEAD + STATES))
        outcome = march(
            p,
            tables,
            0.0,
            y,
            mode,
            breakpoints,
            accuracy_at(p, tolerance),
            log,
            np.empty(0),
            np.empty((0, 0)),
            NO_CARRY,
        )
        ends.append(y[-1])
        logs.append(log[: outcome.logged, 1])
    assert ends[0] == pytest.approx(ends[1], rel=5e-7)
    assert all((log == BRANCHED).sum() >= 4 for log in logs)


def test_a_seat_leak_is_choked_flow_past_the_groove_with_the_intakes_enthalpy():
    """0.4 mm2 from 1.1 MPa and 287 K to 5 bar: 0.684731 S p/sqrt(R T)."""
    balance = added(SeatLeak(0.4e-6))
    mass = 0.684731 * 0.4e-6 * 1.1e6 / np.sqrt(287.05 * 287.0)
    assert balance[GROOVE_MASS] == pytest.approx(mass, rel=1e-6)
    assert balance[GROOVE_ENERGY] == pytest.approx(mass * 1004.675 * 287.0, rel=1e-6)
    assert (balance[MASS], balance[ENERGY]) == (0.0, 0.0)


@pytest.mark.compiled
def test_a_seat_leak_counts_as_engine_air_and_loads_the_cylinder_before_opening():
    tight, leaking = (with_effects(seat_leak=SeatLeak(area)) for area in (0.0, 1e-6))
    runs = [settled(a_machine, 800.0) for a_machine in (tight, leaking)]
    air = [
        indicators(a_machine, run)["engine_air_kg_per_cycle"]
        for a_machine, run in zip((tight, leaking), runs, strict=True)
    ]
    assert air[1] > air[0]
    assert effects_ledger(runs[1].end).mass == 0.0
    before_opening = [np.interp(-10.0 * DEGREE + 2.0 * np.pi, run.angles, run.trace[:, 0]) for run in runs]
    assert before_opening[1] > before_opening[0]
    closed = np.argmax(np.degrees(runs[1].angles) > 250.0)
    assert runs[0].trace[closed, 6] == 0.0
    assert runs[1].trace[closed, 6] > 0.0
