"""What comes out, derived again from the trace and from its definition."""

from math import inf, isnan, log, pi

import numpy as np
import pytest

from apesim.engine.angles import DEGREE
from apesim.engine.cam import raised_cosine
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cylinder import EPV
from apesim.engine.effects.tabulated_cylinder_heat import TabulatedCylinderHeat
from apesim.engine.indicators import ADIABATIC, INDICATORS, indicators, is_adiabatic
from apesim.engine.machine import Machine
from apesim.engine.steady import run_steady
from tests.machines import AMBIENT, RPM, machine, settled

R, K = 287.05, 1.4
FINE = 0.05 * DEGREE
QUADRATURE = 1e-4
"""Error of trapezia of 0.05 degrees."""
SWEPT = 0.25 * pi * 0.085**2 * 0.088


def columns(run):
    return {name.split(" [")[0]: run.trace[:, i] for i, name in enumerate(TRACE)}


@pytest.fixture(scope="module", params=["epv", "epv, receiver", "cam"])
def point(request):
    """A machine at 800 r/min, its settled run with a fine trace, and its indicators."""
    intake, *receiver = request.param.split(", ")
    a_machine = machine(intake=intake, receiver=1.0 if receiver else inf, supply__control_pressure=0.9e6)
    run = settled(a_machine, 800.0, angle_step=FINE)
    return a_machine, run, indicators(a_machine, run)


def test_every_indicator_has_a_unit_and_a_description(point):
    _, _, found = point
    assert list(found) == list(INDICATORS)


def test_work_torque_power_and_mean_pressure_are_one_another(point):
    _, run, found = point
    column = columns(run)
    work = np.trapezoid(column["cylinder_pressure"] - AMBIENT, column["cylinder_volume"])
    assert found["speed_rpm"] == pytest.approx(800.0)
    assert found["indicated_torque_Nm"] == pytest.approx(work / (2.0 * pi), rel=QUADRATURE)
    assert found["indicated_power_W"] == pytest.approx(work * 800.0 / 60.0, rel=QUADRATURE)
    assert found["imep_Pa"] == pytest.approx(work / SWEPT, rel=QUADRATURE)


def test_brake_is_indicated_less_chen_and_flynn_at_the_peak_pressure(point):
    _, run, found = point
    peak = columns(run)["cylinder_pressure"].max()
    speed = 2.0 * 0.088 * 800.0 / 60.0
    fmep = 0.4e5 + 0.005 * peak + 0.08e5 * speed + 0.0008e5 * speed**2
    assert found["peak_cylinder_pressure_Pa"] == pytest.approx(peak, rel=1e-6)
    assert found["peak_cylinder_pressure_Pa"] >= peak * (1.0 - 1e-12)
    assert found["fmep_Pa"] == pytest.approx(fmep, rel=1e-6)
    assert found["bmep_Pa"] == pytest.approx(found["imep_Pa"] - fmep, rel=1e-6)
    assert found["brake_torque_Nm"] == pytest.approx(found["bmep_Pa"] * SWEPT / (2.0 * pi), rel=1e-12)
    assert found["brake_power_W"] == pytest.approx(found["brake_torque_Nm"] * 800.0 * RPM, rel=1e-12)


def test_air_is_what_flows_through_the_groove_net_of_back_flow(point):
    _, run, found = point
    time = (run.angles - run.cycle.start) / run.cycle.speed
    groove, exhaust = columns(run)["groove_flow"], columns(run)["exhaust_flow"]
    assert found["engine_air_kg_per_cycle"] == pytest.approx(np.trapezoid(groove, time), rel=QUADRATURE)
    back = np.trapezoid(np.maximum(0.0, -groove), time)
    assert found["groove_back_flow_kg_per_cycle"] == pytest.approx(back, rel=1e-3, abs=1e-9)
    assert np.trapezoid(exhaust, time) == pytest.approx(found["engine_air_kg_per_cycle"], rel=QUADRATURE)


def test_control_air_of_an_epv_is_two_fillings_of_a_chamber(point):
    """Adiabatic filling of the full volume: at least (p - p0) V/(k R T), if at rest, and at most p V/(R T)."""
    a_machine, _, found = point
    if a_machine.engine.intake != EPV:
        assert found["control_air_kg_per_cycle"] == 0.0
        return
    volume = 11382e-9 + 1134.1e-6 * 9e-3
    least, most = (2.0 * pressure * volume / (R * 287.0) for pressure in ((0.9e6 - AMBIENT) / K, 0.9e6))
    assert least < found["control_air_kg_per_cycle"] < most


def test_specific_air_is_mass_over_work_in_kilograms_per_kilowatt_hour(point):
    _, _, found = point
    engine, control = found["engine_air_kg_per_cycle"], found["control_air_kg_per_cycle"]
    brake, work = (found[f"{name}_torque_Nm"] * 2.0 * pi / 3.6e6 for name in ("brake", "indicated"))
    assert found["specific_air_kg_per_kWh"] == pytest.approx((engine + control) / brake, rel=1e-12)
    assert found["specific_engine_air_kg_per_kWh"] == pytest.approx(engine / brake, rel=1e-12)
    assert found["indicated_specific_air_kg_per_kWh"] == pytest.approx((engine + control) / work, rel=1e-12)
    litres = (engine + control) * 800.0 / 1.185 * 1000.0
    assert found["air_L_per_min_ANR"] == pytest.approx(litres, rel=1e-12)


def test_efficiencies_are_brake_work_over_ideal_work_of_engine_and_control_air_at_their_own_pressures(point):
    a_machine, _, found = point
    brake, temperature = found["brake_torque_Nm"] * 2.0 * pi, 287.0
    ratios = a_machine.supply.pressure / AMBIENT, 0.9e6 / AMBIENT
    air = found["engine_air_kg_per_cycle"], found["control_air_kg_per_cycle"]
    laws = {
        "isothermal_efficiency": lambda r: R * temperature * log(r),
        "isentropic_efficiency": lambda r: K * R / (K - 1.0) * temperature * (1.0 - r ** ((1.0 - K) / K)),
        "full_admission_efficiency": lambda r: R * temperature * (1.0 - 1.0 / r),
    }
    for name, law in laws.items():
        ideal = sum(mass * law(ratio) for mass, ratio in zip(air, ratios, strict=True))
        assert found[name] == pytest.approx(brake / ideal, rel=1e-12), name
    assert found["isothermal_efficiency"] < found["isentropic_efficiency"] < found["full_admission_efficiency"]


def test_exergy_efficiency_is_brake_work_over_flow_exergy_against_the_ambient(point):
    """h - h_0 - T_0 (s - s_0) of ideal air at 287 K, the ambient at 293.15 K."""
    a_machine, _, found = point
    cp, ambient, temperature = K * R / (K - 1.0), 293.15, 287.0
    exergy = sum(
        found[f"{name}_air_kg_per_cycle"]
        * (cp * (temperature - ambient) - ambient * (cp * log(temperature / ambient) - R * log(pressure / AMBIENT)))
        for name, pressure in (("engine", a_machine.supply.pressure), ("control", 0.9e6))
    )
    assert found["exergy_efficiency"] == pytest.approx(found["brake_torque_Nm"] * 2.0 * pi / exergy, rel=1e-12)


def test_lowest_temperature_and_that_of_the_mixed_exhaust_are_those_of_the_trace(point):
    _, run, found = point
    time, column = (run.angles - run.cycle.start) / run.cycle.speed, columns(run)
    temperature, out = column["cylinder_temperature"], np.maximum(0.0, column["exhaust_flow"])
    mixed = np.trapezoid(out * temperature, time) / np.trapezoid(out, time)
    assert found["exhaust_temperature_K"] == pytest.approx(mixed, rel=QUADRATURE)
    assert found["lowest_cylinder_temperature_K"] == pytest.approx(temperature.min(), rel=1e-6)
    assert found["lowest_cylinder_temperature_K"] <= temperature.min()


@pytest.mark.parametrize(
    ("settings", "adiabatic"),
    [
        ({}, True),
        ({"effects_ring_leakage_area": "0.1 mm^2", "effects_chamber_wall_heat_h": "100 W/(m^2 K)"}, True),
        ({"effects_cylinder_wall_heat_h": "200 W/(m^2 K)"}, False),
        ({f"effects.tabulated_cylinder_heat.{TabulatedCylinderHeat._fields[0]}": 0.1}, False),
    ],
)
def test_a_cold_temperature_is_an_adiabatic_limit_where_no_wall_heats_the_cylinder(settings, adiabatic):
    assert is_adiabatic(Machine().with_(**settings)) == adiabatic


def test_cold_temperatures_say_that_they_are_an_adiabatic_limit():
    for name in ("lowest_cylinder_temperature_K", "exhaust_temperature_K"):
        assert ADIABATIC in INDICATORS[name][1]


def test_pressure_before_the_groove_fluctuates_only_with_a_finite_receiver(point):
    a_machine, run, found = point
    if a_machine.engine.receiver.volume == inf:
        assert found["intake_pressure_fluctuation_Pa"] == 0.0
    else:
        receiver = columns(run)["receiver_pressure"]
        assert found["intake_pressure_fluctuation_Pa"] >= receiver.max() - receiver.min() > 1e4
        assert found["intake_pressure_fluctuation_Pa"] == pytest.approx(receiver.max() - receiver.min(), rel=1e-4)


@pytest.mark.compiled
def test_the_highest_and_lowest_intake_pressure_are_found_between_the_rows_of_the_trace():
    """A dip that rows every 0.5 degrees are 1.9 % short of, and rows every 0.01 degrees at a small tolerance meet."""
    a_machine = machine(intake="ideal", targets=(7.2, 70.0), receiver=1.0, engine__receiver__feed_area=5e-4)
    found = indicators(a_machine, settled(a_machine, 434.0))["intake_pressure_fluctuation_Pa"]
    fine = settled(a_machine, 434.0, tolerance=1e-10, angle_step=0.01 * DEGREE)
    receiver = columns(fine)["receiver_pressure"]
    assert found == pytest.approx(receiver.max() - receiver.min(), rel=1e-5)


def crossings(angles, lift, level):
    """Angles at which the lift rises through a level, and at which it falls, linear between rows [deg]."""
    over = lift - level
    before = np.flatnonzero((over[1:] > 0.0) != (over[:-1] > 0.0))
    share = over[before] / (over[before] - over[before + 1])
    at = (angles[before] + share * (angles[before + 1] - angles[before])) / DEGREE
    rising = over[before] <= 0.0
    return at[rising], at[~rising]


HAT = np.array([[-30.0, 0.0], [-10.0, 2e-3], [25.0, 8e-3], [60.0, 5e-3], [110.0, 0.0]]) * [DEGREE, 1.0]
HAT_LATER = HAT + np.array([2.0 * pi, 0.0])


def off_by_turns(one, other):
    """Difference of two angles, a turn counting as none [deg]."""
    return (one - other + 180.0) % 360.0 - 180.0


@pytest.mark.parametrize(
    ("rpm", "options"),
    [
        (800.0, {}),
        (1600.0, {}),
        (1000.0, {"energise": -41.0, "release": 16.0}),
        (1000.0, {"intake": "cam"}),
        (1000.0, {"intake": "cam", "engine__cam__lift_curve": HAT}),
        (1000.0, {"intake": "cam", "engine__cam__lift_curve": HAT_LATER, "energise": 30.0}),
    ],
)
def test_valve_angles_are_where_the_trace_of_the_lift_crosses_the_lap(rpm, options):
    """Linear between rows 0.05 degrees apart."""
    a_machine = machine(**options)
    run = settled(a_machine, rpm, angle_step=FINE)
    found = indicators(a_machine, run)
    lift = columns(run)["lift"]
    (opens,), (closes,) = crossings(run.angles, lift, a_machine.groove.lap)
    assert off_by_turns(found["valve_open_deg"], opens) == pytest.approx(0.0, abs=2e-3)
    assert off_by_turns(found["valve_close_deg"], closes) == pytest.approx(0.0, abs=2e-3)
    assert 0.0 < found["valve_close_deg"] - found["valve_open_deg"] < 360.0
    assert found["peak_lift_m"] == pytest.approx(lift.max(), rel=1e-5)


def test_contacts_are_where_the_trace_of_the_lift_meets_the_stops():
    a_machine = machine()
    run = settled(a_machine, 800.0, angle_step=FINE)
    found = indicators(a_machine, run)
    lift, velocity = columns(run)["lift"], columns(run)["velocity"]
    full = run.angles[np.flatnonzero(lift >= 9e-3 * (1.0 - 1e-9))[0]] / DEGREE
    closed = run.angles[np.flatnonzero((lift <= 1e-12) & (run.angles > 2.0 * full * DEGREE))[0]] / DEGREE
    assert full - 0.05 <= found["full_open_deg"] <= full
    assert closed - 0.05 <= found["closed_deg"] <= closed
    opening, closing = (run.angles / DEGREE < full), (run.angles / DEGREE > 80.0)
    assert found["opening_seating_speed_m_s"] == pytest.approx(velocity[opening][-1], rel=1e-2)
    assert found["closing_seating_speed_m_s"] == pytest.approx(-velocity[closing & (lift > 0.0)][-1], rel=1e-2)
    assert 0.0 < found["fluctuation"] < 1.0


def test_without_lap_the_groove_is_open_while_the_valve_is_off_its_closed_stop():
    a_machine = machine(groove__lap=0.0)
    run = settled(a_machine, 1000.0, angle_step=FINE)
    found = indicators(a_machine, run)
    lift, degrees = columns(run)["lift"], run.angles / DEGREE
    assert found["valve_open_deg"] == pytest.approx(degrees[np.flatnonzero(lift > 1e-12)[0]], abs=0.05)
    assert found["valve_close_deg"] == found["closed_deg"]


def test_the_ideal_valve_opens_and_closes_at_its_targets():
    a_machine = machine(intake="ideal", targets=(-3.0, 60.0))
    found = indicators(a_machine, settled(a_machine, 1000.0))
    assert found["valve_open_deg"] == pytest.approx(-3.0)
    assert found["valve_close_deg"] == pytest.approx(60.0)
    assert found["control_air_kg_per_cycle"] == 0.0
    assert isnan(found["opening_seating_speed_m_s"])
    assert isnan(found["fluctuation"])


def test_a_cam_that_does_not_lift_to_the_lap_never_opens():
    a_machine = machine(intake="cam", engine__cam__lift=0.8e-3)
    found = indicators(a_machine, settled(a_machine, 1000.0))
    assert found["engine_air_kg_per_cycle"] == 0.0
    assert isnan(found["valve_open_deg"])
    assert isnan(found["valve_close_deg"])
    assert found["peak_lift_m"] == 0.8e-3


def test_a_lift_curve_reaches_its_peak_and_its_end_where_its_rows_say():
    a_machine = machine(intake="cam", engine__cam__lift_curve=HAT)
    found = indicators(a_machine, settled(a_machine, 1000.0))
    assert found["full_open_deg"] == pytest.approx(25.0)
    assert found["closed_deg"] == pytest.approx(110.0)
    assert isnan(found["fluctuation"])


@pytest.mark.parametrize("groove", [{}, {"groove__lap": 0.0}, {"groove__geometry": 1}])
@pytest.mark.parametrize("receiver", [inf, 1.0])
@pytest.mark.compiled
def test_a_lift_curve_of_a_raised_cosine_gives_its_results(groove, receiver):
    """A chord of 0.05 degrees lies at most 4.5 mm (pi/25)^2 0.05^2/8 under its arc, 2.2e-5 mm of some 8 mm."""
    angles = np.linspace(-5.0, 70.0, 1501) * DEGREE
    cam = machine(intake="cam", receiver=receiver, **groove)
    opens, closes, peak, flank, _ = cam.engine.cam.resolve_lift(cam.valve.stroke)
    lift = [peak * raised_cosine(angle, opens, closes, flank) for angle in angles[:-1]] + [0.0]
    sampled = machine(
        intake="cam", receiver=receiver, engine__cam__lift_curve=np.column_stack((angles, lift)), **groove
    )
    one, other = (indicators(a_machine, settled(a_machine, 1000.0)) for a_machine in (cam, sampled))
    for name in ("indicated_torque_Nm", "brake_torque_Nm", "engine_air_kg_per_cycle", "peak_cylinder_pressure_Pa"):
        assert one[name] == pytest.approx(other[name], rel=1e-5), name
    for name in ("valve_open_deg", "valve_close_deg", "closed_deg"):
        assert one[name] == pytest.approx(other[name], abs=1e-2), name
    assert one["full_open_deg"] == pytest.approx(other["full_open_deg"], abs=0.05)
    assert other["mass_closure"] < 1e-12 and other["energy_closure"] < 1e-11


def test_a_closing_from_part_of_the_lift_has_a_seating_speed():
    """At 1600 r/min the valve reaches 7.08 mm and closes at 1.4358 m/s, in an independent solution."""
    a_machine = machine()
    found = indicators(a_machine, settled(a_machine, 1600.0))
    assert isnan(found["full_open_deg"])
    assert found["closing_seating_speed_m_s"] == pytest.approx(1.4358, abs=1e-4)


def test_ratios_over_work_that_is_not_positive_are_undefined():
    """The valve opens as the piston goes up; then just too little torque for the friction."""
    braking = machine(energise=-120.0, release=-60.0)
    found = indicators(braking, settled(braking, 400.0))
    assert found["indicated_torque_Nm"] < 0.0
    ratios = [name for name in found if "efficiency" in name or "specific" in name]
    assert len(ratios) == 7
    assert all(isnan(found[name]) for name in ratios)
    rubbing = machine(engine__friction__constant=10e5)
    found = indicators(rubbing, settled(rubbing, 800.0))
    assert found["indicated_torque_Nm"] > 0.0 > found["brake_torque_Nm"]
    assert [name for name in ratios if not isnan(found[name])] == ["indicated_specific_air_kg_per_kWh"]


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"receiver": 1.0},
        {"receiver": 1.0, "control_air": "receiver"},
        {"intake": "cam", "receiver": 1.0},
        {"effects__blow_by__area": 0.5e-6, "effects__cylinder_wall_heat__h": 200.0},
        {"air__model": 1, "receiver": 1.0},
    ],
)
def test_mass_and_energy_close_even_far_from_the_periodic_state(options):
    a_machine = machine(**options)
    run = run_steady(a_machine, 800.0 * RPM, max_cycles=2)
    found = indicators(a_machine, run)
    assert found["mass_closure"] < 1e-12
    assert found["energy_closure"] < 1e-11


def test_mass_and_energy_close_where_the_groove_never_opens():
    a_machine = machine(intake="cam", engine__cam__lift=0.5e-3)
    found = indicators(a_machine, settled(a_machine, 800.0))
    assert found["engine_air_kg_per_cycle"] == 0.0
    assert found["mass_closure"] < 1e-12
    assert found["energy_closure"] < 1e-11


def test_closure_sees_what_is_missing():
    a_machine = machine()
    run = settled(a_machine, 800.0)
    for index in (6, 7):
        end = run.end.copy()
        end[index] *= 1.0 + 1e-3
        found = indicators(a_machine, run._replace(end=end))
        assert found["mass_closure" if index == 6 else "energy_closure"] > 1e-5
