"""The valve's effects, all alike: nothing at strength zero, something above it, and all still closes."""

import numpy as np
import pytest

from apesim.effect import NoEffects
from apesim.engine.machine import Machine
from apesim.quantities.settings import dumps, load
from apesim.valve.actuator import MODES, PHASE, actuator_rates, closed_at_rest
from apesim.valve.bench import bench_of, run_bench
from apesim.valve.effects import VALVE_EFFECTS, ValveEffects, ValveLaws, ValveTables
from apesim.valve.effects.bounce import Bounce
from apesim.valve.effects.coulomb_friction import CoulombFriction
from apesim.valve.motion import start_actuator_segment
from tests.machines import turned_on
from tests.valve.test_bench import BenchMachine, numbers

PULSE = 30e-3
INTAKE = 0.6e6
ON = {effect.name: turned_on(effect) for effect in VALVE_EFFECTS}
BREAKAWAY_ALONE = CoulombFriction(0.0, 6.0)
every = pytest.mark.parametrize("effect", VALVE_EFFECTS, ids=[effect.name for effect in VALVE_EFFECTS])
MARCHED = [effect for effect in VALVE_EFFECTS if effect.slots != ("sensor",)]
every_marched = pytest.mark.parametrize("effect", MARCHED, ids=[effect.name for effect in MARCHED])
OF_SENSORS = [effect for effect in VALVE_EFFECTS if effect.slots == ("sensor",)]
every_of_sensors = pytest.mark.parametrize("effect", OF_SENSORS, ids=[effect.name for effect in OF_SENSORS])


def machine_with(**effects):
    return BenchMachine()._replace(effects=ValveEffects(**effects))


def run_with(**effects):
    return run_bench(machine_with(**effects), PULSE, intake_pressure=INTAKE)


def rates_at(phase, machine, position=4e-3, speed=1.2, intake_pressure=None):
    """Bench, state and rates just after the energising, chamber A charged, B vented; speed in the phase's sense."""
    p, tables = bench_of(machine, [0.0, PULSE], intake_pressure=intake_pressure)
    y = np.append(closed_at_rest(p.actuator, p.supply.control), np.zeros(7))
    y[0], y[1] = position, speed * np.sign(phase)
    mode = np.zeros(MODES)
    mode[PHASE] = phase
    start_actuator_segment(p.actuator, tables, 0.0, 1e-6, y, mode, p.supply)
    return p, y, actuator_rates(p.actuator, 0.0, y, mode, p.supply)


def off_beside_others(effect):
    """Parameters of no strength, the others another than their defaults."""
    strengths = effect.strengths or effect.parameters._fields[:1]
    values = effect.parameters()._asdict()
    return effect.parameters(
        **{n: -v if n in strengths and not v else v if n in strengths else 1.5 * v for n, v in values.items()}
    )


@every
def test_an_effect_says_what_it_is(effect):
    assert effect.slots
    assert all((effect.equation, effect.source, effect.seen_in, effect.isolated_by))
    assert not effect.is_on(effect.parameters())
    assert effect.is_on(ON[effect.name])


@every_marched
def test_an_effect_that_is_on_changes_the_run(effect):
    assert not np.array_equal(numbers(run_with(**{effect.name: ON[effect.name]})), numbers(run_with()))


@every_of_sensors
@pytest.mark.compiled
def test_an_effect_of_sensors_changes_no_bit_of_the_run(effect):
    assert np.array_equal(numbers(run_with(**{effect.name: ON[effect.name]})), numbers(run_with()))


@pytest.mark.compiled
def test_laws_at_strength_zero_that_are_looked_at_change_no_bit():
    # A restitution too small for any rebound has all laws compiled in, and does nothing itself.
    assert type(bench_of(machine_with(bounce=Bounce(1e-9)), [0.0, PULSE])[0].actuator.effects) is ValveLaws
    assert np.array_equal(numbers(run_with(bounce=Bounce(1e-9))), numbers(run_with()))


@every
def test_effects_without_law_or_contact_are_marched_without_any_law(effect):
    found = bench_of(machine_with(**{effect.name: ON[effect.name]}), [0.0, PULSE])[0].actuator.effects
    laws = ValveTables if effect.tabulated else ValveLaws
    assert type(found) is (NoEffects if effect.slots in (("adjust",), ("sensor",)) else laws)


@every_marched
@pytest.mark.parametrize("other", ["bounce", "seal_friction", "solenoid_b_delay"])
@pytest.mark.compiled
def test_strength_zero_changes_no_bit_with_another_effect_on(effect, other):
    if effect.name != other:
        beside = {other: ON[other]}
        off = {effect.name: off_beside_others(effect)}
        assert np.array_equal(numbers(run_with(**beside, **off)), numbers(run_with(**beside)))


@every_marched
@pytest.mark.parametrize("share", [0.1, 1.0])
def test_mass_energy_and_work_close_with_an_effect_on(effect, share):
    run = run_with(**{effect.name: turned_on(effect, share)})
    assert run.status == 0
    assert run.closure["mass"] <= 1e-9
    assert run.closure["energy"] <= 1e-9
    assert run.closure["work"] <= 1e-6


@every
@pytest.mark.parametrize("supply", [0.3e6, 1.1e6])
@pytest.mark.compiled
def test_the_measures_converge_with_an_effect_on(effect, supply):
    """Corners of a law end a step; the error is some tolerances' then; stepped over, it was up to 520."""
    machine = machine_with(**{effect.name: turned_on(effect, 1.0)})
    machine = machine._replace(supply=machine.supply._replace(pressure=supply))
    default, fine = (run_bench(machine, 50e-3, tolerance=tolerance) for tolerance in (1e-7, 1e-12))
    for stroke in ("opening", "closing"):
        assert getattr(default, stroke)[:3] == pytest.approx(getattr(fine, stroke)[:3], rel=1e-6, nan_ok=True)


@every
def test_a_machine_file_with_an_effect_on_reads_back_bit_for_bit(effect, tmp_path):
    machine = Machine()._replace(effects=Machine().effects._replace(**{effect.name: turned_on(effect, 1.0 / 3.0)}))
    path = tmp_path / "machine.toml"
    path.write_text(dumps(machine))
    assert load(Machine, path).effects == machine.effects


def test_a_breakaway_force_alone_acts_whether_or_not_another_effect_is_on():
    def share_of(**effects):
        """What the breakaway force adds to the delay."""
        return run_with(coulomb_friction=BREAKAWAY_ALONE, **effects).opening.delay / run_with(**effects).opening.delay

    assert (share_of() > 1.0) == (share_of(bounce=ON["bounce"]) > 1.0)
