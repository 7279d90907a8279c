"""The engine's effects, all alike: nothing at strength zero, something above it, and all still closes."""

import numpy as np
import pytest

from apesim.effect import NoEffects
from apesim.engine.cycle.operating_point import cycle_of
from apesim.engine.effects import ALL_EFFECTS, ENGINE_EFFECTS, EngineLaws, EngineTables
from apesim.engine.effects.exhaust_timing import ExhaustTiming
from apesim.engine.effects.seat_leak import SeatLeak
from apesim.engine.effects.tabulated_cylinder_heat import TabulatedCylinderHeat
from apesim.engine.indicators import indicators
from apesim.engine.machine import Machine
from apesim.quantities.settings import dumps, load
from apesim.valve.effects import ValveLaws, ValveTables
from apesim.valve.effects.bounce import Bounce
from apesim.valve.effects.tabulated_force import TabulatedForce
from tests.engine.effects.test_engine_effects import SPEED, with_effects
from tests.machines import settled, turned_on


def test_the_library_names_every_effect_once():
    names = [effect.name for effect in ALL_EFFECTS]
    assert len(set(names)) == len(names)


every = pytest.mark.parametrize("effect", ENGINE_EFFECTS, ids=[effect.name for effect in ENGINE_EFFECTS])
MARCHED = [effect for effect in ENGINE_EFFECTS if effect.slots != ("sensor",)]
every_marched = pytest.mark.parametrize("effect", MARCHED, ids=[effect.name for effect in MARCHED])
OF_SENSORS = [effect for effect in ALL_EFFECTS if effect.slots == ("sensor",)]
every_of_sensors = pytest.mark.parametrize("effect", OF_SENSORS, ids=[effect.name for effect in OF_SENSORS])


@every
def test_an_effect_says_what_it_is(effect):
    assert effect.slots
    assert all((effect.equation, effect.source, effect.seen_in, effect.isolated_by))
    assert not effect.is_on(effect.parameters())
    assert effect.is_on(turned_on(effect))


@every_of_sensors
def test_an_effect_of_sensors_changes_no_bit_of_the_run(effect):
    read, plain = (settled(with_effects(**on), 800.0) for on in ({effect.name: turned_on(effect)}, {}))
    assert np.array_equal(read.end, plain.end)
    assert np.array_equal(read.trace, plain.trace)


@every_marched
@pytest.mark.parametrize("share", [0.1, 1.0])
def test_mass_and_energy_close_with_an_effect_on_and_it_changes_what_comes_out(effect, share):
    a_machine = with_effects(**{effect.name: turned_on(effect, share)})
    run = settled(a_machine, 800.0)
    found = indicators(a_machine, run)
    assert found["mass_closure"] < 1e-12
    assert found["energy_closure"] < 1e-11
    plain = indicators(with_effects(), settled(with_effects(), 800.0))
    assert found["brake_torque_Nm"] != plain["brake_torque_Nm"]


@every
def test_effects_without_law_or_contact_are_marched_without_any_law(effect):
    p, _, _ = cycle_of(with_effects(**{effect.name: turned_on(effect)}), SPEED)
    laws = EngineTables if effect.tabulated else EngineLaws
    assert type(p.effects) is (NoEffects if effect.slots in (("adjust",), ("sensor",)) else laws)


def kinds_of_laws(**effects):
    p, _, _ = cycle_of(with_effects(**effects), SPEED)
    return type(p.actuator.effects), type(p.effects)


def test_one_law_that_is_on_has_those_of_valve_and_engine_compiled_in():
    assert kinds_of_laws() == kinds_of_laws(exhaust_timing=ExhaustTiming(0.1)) == (NoEffects, NoEffects)
    assert kinds_of_laws(bounce=Bounce(0.1)) == kinds_of_laws(seat_leak=SeatLeak(1e-9)) == (ValveLaws, EngineLaws)
    on_the_valve, on_the_engine = TabulatedForce(1.0), TabulatedCylinderHeat(0.1)
    assert kinds_of_laws(tabulated_force=on_the_valve, seat_leak=SeatLeak(1e-9)) == (ValveTables, EngineTables)
    assert kinds_of_laws(tabulated_cylinder_heat=on_the_engine, bounce=Bounce(0.1)) == (ValveTables, EngineTables)


def test_laws_at_strength_zero_that_are_looked_at_change_no_bit():
    # A restitution too small for any rebound has all laws compiled in, and does nothing itself.
    plain, idle = (settled(with_effects(**effects), 800.0) for effects in ({}, {"bounce": Bounce(1e-9)}))
    assert np.array_equal(plain.end, idle.end)
    assert np.array_equal(plain.trace, idle.trace)


@every_marched
@pytest.mark.parametrize("other", ["blow_by", "exhaust_timing"])
def test_strength_zero_changes_no_bit_with_another_effect_on(effect, other):
    if effect.name == other:
        return
    (beside,) = ({other: turned_on(found)} for found in ENGINE_EFFECTS if found.name == other)
    strengths = effect.strengths or effect.parameters._fields[:1]
    off = {effect.name: effect.parameters(**dict.fromkeys(strengths, -0.0))}
    plain, idle = (settled(with_effects(**effects), 800.0) for effects in (beside, beside | off))
    assert np.array_equal(plain.end, idle.end)
    assert np.array_equal(plain.trace, idle.trace)


@every
def test_a_machine_file_with_an_effect_on_reads_back_bit_for_bit(effect, tmp_path):
    a_machine = with_effects(**{effect.name: turned_on(effect, 1.0 / 3.0)})
    path = tmp_path / "machine.toml"
    path.write_text(dumps(a_machine))
    assert load(Machine, path).effects == a_machine.effects
