import numpy as np
import pytest

from apesim.march.adaptive import LOG_HEAD, Status
from apesim.valve.actuator import PHASE
from apesim.valve.bench import run_bench
from apesim.valve.effects.bounce import Bounce
from apesim.valve.motion import MET_CLOSED, MET_OPEN
from apesim.valve.piston import HELD_CLOSED, HELD_OPEN
from tests.valve.effects.test_valve_effects import PULSE, machine_with, run_with
from tests.valve.test_bench import LIFT, VELOCITY
from tests.valve.test_motion import marched


def contacts_of(restitution, stop, until=2.0 * PULSE):
    log, y, mode, _, status = marched(machine_with(bounce=Bounce(restitution)), PULSE, until)
    assert status == Status.DONE
    return log[log[:, 1] == stop], y, mode


@pytest.mark.parametrize("restitution", [0.2, 0.4, 0.6])
@pytest.mark.parametrize(
    ("stop", "sign", "until", "held"),
    [
        (MET_OPEN, -1.0, PULSE, HELD_OPEN),
        (MET_CLOSED, 1.0, 2.0 * PULSE, HELD_CLOSED),
    ],
)
def test_a_piston_bounces_with_falling_speeds_and_is_held_in_the_end(restitution, stop, sign, until, held):
    contacts, y, mode = contacts_of(restitution, stop, until)
    speeds = sign * contacts[:, LOG_HEAD + 1]
    assert len(speeds) >= 3
    assert (np.diff(np.abs(speeds)) < 0.0).all()
    # Each rebound keeps its share or less of the speed, and below 1e-3 m/s it ends.
    assert len(speeds) <= 2 + np.log(1e-3 / speeds[0]) / np.log(restitution)
    assert (mode[PHASE], y[1]) == (held, 0.0)


@pytest.mark.parametrize("restitution", [0.2, 0.6])
def test_every_contact_is_met_on_the_way_to_the_stop(restitution):
    contacts, *_ = contacts_of(restitution, MET_OPEN, PULSE)
    assert (contacts[:, LOG_HEAD + 1] < 0.0).all()


def test_the_first_rebound_has_its_share_of_the_seating_speed():
    sample = 1e-6
    run = run_bench(machine_with(bounce=Bounce(0.4)), PULSE, until=15e-3, sample=sample)
    after = np.searchsorted(run.times, run.opening.contact)
    # Within a sample the speed changes by at most 1.1e6 Pa * 1134 mm2 / 0.1145 kg times 1e-6 s.
    assert run.trace[after, VELOCITY] == pytest.approx(-0.4 * run.opening.seating_speed, abs=0.011)
    assert run.opening.seating_speed == pytest.approx(run_with().opening.seating_speed, rel=1e-6)
    assert run.trace[:, LIFT].max() <= 9e-3 + 1e-12


def test_without_bounce_there_is_one_contact():
    contacts, y, mode = contacts_of(0.0, MET_OPEN, PULSE)
    assert len(contacts) == 1
    assert (y[0], y[1], mode[PHASE]) == (0.0, 0.0, HELD_OPEN)
