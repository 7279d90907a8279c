import pickle
from typing import NamedTuple

import numba
import numpy as np
import pytest

from apesim.effect import (
    Effect,
    Library,
    NoEffects,
    acting,
    add_laws,
    adjusted,
    chosen,
    contact,
    kind_of_march,
    law,
    restitution,
    sensed,
)
from apesim.engine.effects import EngineLaws, EngineTables
from apesim.kernel import kernel
from apesim.valve.effects import ValveLaws, ValveTables

# --- a library of three effects, and one that is not in it ---


class Push(NamedTuple):
    force: float = 0.0


class Warmth(NamedTuple):
    heat: float = 0.0
    leak: float = 0.0
    radius: float = 7.0


class Rubber(NamedTuple):
    share: float = 0.0


class Foreign(NamedTuple):
    strength: float = 1.0


class State(NamedTuple):
    speed: float


@law.for_type(Push)
@kernel
def push(effect, state, balance):
    balance[0] += effect.force * state.speed


@law.for_type(Warmth)
@kernel
def warmth(effect, state, balance):
    balance[0] += 100.0 * effect.heat
    balance[1] += effect.leak


@contact.for_type(Rubber)
@kernel
def rubber(effect, speed):
    return effect.share / speed


class Machine(NamedTuple):
    mass: float


class Tables(NamedTuple):
    lags: np.ndarray


def heavier(effect, machine, tables):
    return machine._replace(mass=machine.mass + effect.force), tables


def doubled(effect, machine, tables):
    return machine._replace(mass=2.0 * machine.mass), tables._replace(lags=tables.lags + effect.leak)


def effect_of(name, parameters, **slots):
    return Effect(name, parameters, "", "", "", "", **slots)


LIBRARY = (
    effect_of("push", Push, adjust=heavier),
    effect_of("warmth", Warmth, strengths=("heat", "leak"), adjust=doubled),
    effect_of("rubber", Rubber),
)


class Effects(NamedTuple):
    push: Push = Push()
    warmth: Warmth = Warmth()
    rubber: Rubber = Rubber()


COMPILED = Library(LIBRARY, (NoEffects, Effects, Effects))


class AllEffects(NamedTuple):
    """Effects that a machine file gives: of other libraries too, and in another order."""

    foreign: Foreign = Foreign()
    rubber: Rubber = Rubber()
    warmth: Warmth = Warmth()
    push: Push = Push()


# --- on and off ---


def test_the_first_parameter_is_the_strength():
    assert not LIBRARY[0].is_on(Push())
    assert LIBRARY[0].is_on(Push(-1e-300))
    assert not LIBRARY[2].is_on(Rubber())


def test_of_several_strengths_any_switches_the_effect_on_and_nothing_else_does():
    assert LIBRARY[1].is_on(Warmth(heat=1.0))
    assert LIBRARY[1].is_on(Warmth(leak=1.0))
    assert not LIBRARY[1].is_on(Warmth(radius=3.0))
    assert not effect_of("warmth", Warmth).is_on(Warmth(leak=1.0))


def test_chosen_takes_its_own_effects_by_name():
    own = chosen(COMPILED, AllEffects(push=Push(2.0), rubber=Rubber(0.5)))
    assert type(own) is Effects
    assert own == Effects(push=Push(2.0), rubber=Rubber(0.5))


def test_an_effect_of_another_library_switches_nothing_on():
    assert type(chosen(COMPILED, AllEffects(foreign=Foreign(9.0)))) is NoEffects


def test_a_table_that_is_on_has_all_laws_compiled_in_and_otherwise_none_of_the_tables():
    library = (*LIBRARY[:2], effect_of("rubber", Rubber, tabulated="force"))
    laws, tables = (acting("Acting", __name__, library, tables) for tables in (False, True))
    compiled = Library(library, (NoEffects, laws, tables))
    assert laws._fields == ("push", "warmth")
    assert tables._fields == ("push", "warmth", "rubber")
    for effects, kind, expected in (
        (AllEffects(), 0, NoEffects),
        (AllEffects(push=Push(2.0)), 1, laws),
        (AllEffects(rubber=Rubber(0.5)), 2, tables),
    ):
        assert kind_of_march(library, effects) == kind
        assert type(chosen(compiled, effects)) is expected
    assert type(chosen(compiled, AllEffects(), 2)) is tables
    assert type(chosen(compiled, AllEffects(rubber=Rubber(0.5)), 1)) is tables


def test_the_laws_from_outside_are_compiled_in_where_one_of_them_is_on_and_else_not():
    library = (LIBRARY[0], LIBRARY[1]._replace(layer="valve"), effect_of("rubber", Rubber, tabulated="force"))
    kinds = [(tables, outside) for outside in (False, True) for tables in (False, True)]
    marches = (NoEffects, *(acting("Acting", __name__, library, *kind) for kind in kinds))
    assert [march._fields for march in marches] == [
        (),
        ("push",),
        ("push", "rubber"),
        ("push", "warmth"),
        ("push", "warmth", "rubber"),
    ]
    for kind, effects in enumerate(
        (
            AllEffects(),
            AllEffects(push=Push(2.0)),
            AllEffects(rubber=Rubber(0.5)),
            AllEffects(warmth=Warmth(heat=1.0)),
            AllEffects(warmth=Warmth(heat=1.0), rubber=Rubber(0.5)),
        )
    ):
        assert kind_of_march(library, effects) == kind
        assert type(chosen(Library(library, marches), effects)) is marches[kind]


@pytest.mark.parametrize("laws", [ValveLaws, EngineLaws, ValveTables, EngineTables])
def test_the_compile_cache_finds_the_laws_again(laws):
    """A type that cannot be found by its module and name has its kernels compiled anew in every process."""
    assert pickle.loads(pickle.dumps(laws)) is laws


# --- adjust ---


def test_effects_that_are_on_adjust_the_machine_in_the_librarys_order():
    effects = Effects(Push(3.0), Warmth(leak=0.25), Rubber(1.0))
    machine, tables = adjusted(LIBRARY, effects, Machine(10.0), Tables(np.zeros(2)))
    assert machine == Machine(26.0)
    assert tables.lags.tolist() == [0.25, 0.25]


def test_effects_that_are_off_leave_machine_and_tables_as_they_are():
    machine, tables = Machine(10.0), Tables(np.zeros(2))
    same_machine, same_tables = adjusted(LIBRARY, Effects(rubber=Rubber(1.0)), machine, tables)
    assert same_machine is machine
    assert same_tables is tables


# --- sensor ---


class Scale(NamedTuple):
    share: float = 0.0


class Shift(NamedTuple):
    by: float = 0.0


SENSORS = (
    effect_of("shift", Shift, sensor=lambda effect, reading: reading + effect.by),
    effect_of("scale", Scale, sensor=lambda effect, reading: reading * effect.share),
)


class Read(NamedTuple):
    shift: Shift
    scale: Scale


def test_effects_of_sensors_that_are_on_are_applied_in_the_librarys_order():
    assert sensed(SENSORS, Read(Shift(3.0), Scale(2.0)), 10.0) == 26.0
    assert sensed(SENSORS, Read(Shift(3.0), Scale()), 10.0) == 13.0


def test_effects_of_sensors_act_in_no_march():
    assert [effect.slots for effect in SENSORS] == [("sensor",), ("sensor",)]
    assert acting("Acting", __name__, (*SENSORS, *LIBRARY))._fields == ("push", "warmth", "rubber")


# --- laws and contacts, compiled and plain ---


def sum_of_laws(effects, state, balance):
    add_laws(effects, state, balance)
    return balance


def largest_restitution(effects, speed):
    return restitution(effects, speed)


both = pytest.mark.parametrize("mode", [numba.njit, lambda function: function], ids=["compiled", "plain"])


@both
def test_every_effect_of_a_tuple_adds_to_the_balance(mode):
    effects = Effects(Push(2.0), Warmth(heat=0.5, leak=-1.0), Rubber(0.3))
    balance = mode(sum_of_laws)(effects, State(4.0), np.array([1.0, 1.0]))
    assert balance.tolist() == [1.0 + 8.0 + 50.0, 0.0]


@both
def test_a_tuple_of_one_effect_and_of_the_same_effect_twice_add_up(mode):
    assert mode(sum_of_laws)((Push(2.0),), State(4.0), np.zeros(2)).tolist() == [8.0, 0.0]
    assert mode(sum_of_laws)((Push(2.0), Push(0.5)), State(4.0), np.zeros(2)).tolist() == [10.0, 0.0]


@both
def test_effects_without_a_law_add_nothing(mode):
    assert mode(sum_of_laws)((Rubber(0.3),), State(4.0), np.array([5.0, 6.0])).tolist() == [5.0, 6.0]


@both
def test_the_largest_restitution_counts_and_none_is_zero(mode):
    assert mode(largest_restitution)((Push(9.0), Rubber(0.3), Rubber(0.8)), 2.0) == 0.4
    assert mode(largest_restitution)((Push(9.0), Warmth()), 2.0) == 0.0
