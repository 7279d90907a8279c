"""The law of the feedback on the valves' timing by itself: gain, limits, missed strokes."""

from math import nan

import pytest

import apesim
from apesim import FeedbackTiming, SensorReadings

MACHINE = apesim.Machine()
READINGS = SensorReadings(
    time_s=1.0,
    turns=10,
    mean_speed_rpm=1000.0,
    lowest_speed_rpm=1000.0,
    highest_speed_rpm=1000.0,
    end_speed_rpm=1000.0,
    valve_open_deg=(15.0,),
    valve_close_deg=(90.0,),
    full_lift=(1.0,),
    energise_deg=(-5.0,),
    release_deg=(70.0,),
    supply_pressure_Pa=1.1e6,
    receiver_pressure_Pa=1.1e6,
    lowest_receiver_pressure_Pa=1.0e6,
    engine_air_kg=1e-3,
    control_air_kg=1e-4,
)


def test_a_gain_corrects_its_share_of_an_error():
    commands = FeedbackTiming(MACHINE, gain=0.2)(READINGS)
    assert commands.energise_deg == pytest.approx([-5.0 - 0.2 * 20.0])
    assert commands.release_deg == pytest.approx([70.0 - 0.2 * 20.0])


def test_lead_times_stay_where_the_speed_changes():
    law = FeedbackTiming(MACHINE)
    law(READINGS)
    at_targets = READINGS._replace(valve_open_deg=(-5.0,), valve_close_deg=(70.0,))
    slow, fast = (law(at_targets._replace(mean_speed_rpm=speed)) for speed in (1000.0, 2000.0))
    for name, target in (("energise_deg", -5.0), ("release_deg", 70.0)):
        assert target - getattr(fast, name)[0] == pytest.approx(2.0 * (target - getattr(slow, name)[0]))


def test_one_missed_stroke_changes_nothing_and_more_make_the_pulse_longer():
    law, missed = FeedbackTiming(MACHINE), READINGS._replace(valve_open_deg=(nan,), valve_close_deg=(nan,))
    first, second, third = law(missed), law(missed), law(missed)
    assert first.energise_deg == second.energise_deg == third.energise_deg == pytest.approx([-5.0])
    releases = [first.release_deg[0], second.release_deg[0], third.release_deg[0]]
    assert releases == pytest.approx([70.0, 76.0, 82.0])  # 1 ms at 1000 r/min is 6 deg
    law(READINGS)
    assert law(missed).release_deg[0] == pytest.approx(law.targets[0][1] - 6000.0 * law.leads[0][1])


def test_no_window_is_empty_or_a_turn_and_a_limit_gathers_no_error():
    law = FeedbackTiming(MACHINE, gain=0.9)
    for _ in range(50):
        never = law(READINGS._replace(valve_open_deg=(-90.0,), valve_close_deg=(260.0,)))
    assert 1.0 <= never.release_deg[0] - never.energise_deg[0] <= 359.0
    for _ in range(50):
        late = law(READINGS._replace(valve_open_deg=(100.0,), valve_close_deg=(400.0,)))
    assert late.energise_deg[0] >= -185.0 and late.release_deg[0] - late.energise_deg[0] >= 1.0
    back = law(READINGS._replace(valve_open_deg=(-25.0,), valve_close_deg=(70.0,)))
    assert back.energise_deg[0] == pytest.approx(late.energise_deg[0] + 0.9 * 20.0)  # at once, as nothing was gathered


def test_commands_stay_within_their_ranges_where_targets_are_at_the_ends_of_theirs():
    for targets in ((-359.0, -280.0), (350.0, 420.0)):
        law = FeedbackTiming(MACHINE, gain=0.9)
        law.targets = [targets]
        for error in (200.0, -200.0):
            for _ in range(30):
                commands = law(READINGS._replace(valve_open_deg=(targets[0] + error,)))
            assert -360.0 <= commands.energise_deg[0] <= 360.0 and -360.0 <= commands.release_deg[0] <= 720.0


def test_no_pulse_is_shorter_than_the_shortest_one():
    law = FeedbackTiming(MACHINE, min_pulse_s=0.015)
    commands = law(READINGS)
    assert commands.release_deg[0] - commands.energise_deg[0] == pytest.approx(0.015 * 6000.0)


def test_nothing_changes_while_the_shaft_turns_backwards():
    assert FeedbackTiming(MACHINE)(READINGS._replace(mean_speed_rpm=-300.0)) is None
