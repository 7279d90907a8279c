"""Mutants of the physics: what notices one is found, and nothing of the checkout is changed."""

import sys
from pathlib import Path

import pytest

pytest.importorskip("cosmic_ray", reason='python -m pip install -e ".[laboratory]"')

from tests.campaigns import mutants
from tests.campaigns.campaign import Outcome
from tests.campaigns.mutants import COMPILED, PLAIN, PYTEST, Mutant


@pytest.mark.slow
def test_mutants_are_of_the_physics_and_in_an_order_that_stays():
    listed = mutants.mutants()
    assert len(listed) > 5000
    assert len(set(listed)) == len(listed)
    assert {one.path.partition("/")[0] for one in listed} == {"apesim", "engine", "valve"}
    assert listed[0] == Mutant(*listed[0])
    mutants.mutants.cache_clear()
    assert mutants.mutants() == listed


@pytest.mark.slow
def test_a_mutant_is_caught_by_the_examples_or_its_line_is_kept(monkeypatch):
    path, operator = "engine/friction.py", "core/ReplaceBinaryOperator_Mul_Add"
    one = next(mutant for mutant in mutants.mutants() if (mutant.path, mutant.operator) == (path, operator))
    monkeypatch.setattr(mutants, "mutants", lambda: [one])
    before = (mutants.project() / path).read_text()
    examples = next(mutants.tests_of(path))
    passing, failing = ((sys.executable, "-c", words) for words in ("pass", "raise SystemExit(3)"))
    monkeypatch.setattr(mutants, "tests_of", lambda path: [examples])
    assert mutants.trial(0) == Outcome(f"{path}: caught")
    monkeypatch.setattr(mutants, "tests_of", lambda path: [passing])
    left = mutants.trial(0)
    assert left.word == f"{path}: survives"
    assert left.detail.startswith(f"{path}:{one.line}: ReplaceBinaryOperator_Mul_Add: ")
    monkeypatch.setattr(mutants, "tests_of", lambda path: [failing])
    with pytest.raises(RuntimeError, match="fails where nothing is changed, too"):
        mutants.trial(0)
    assert (mutants.project() / path).read_text() == before
    assert mutants.trial(1).word == "none: there are no more mutants"


FAILING = """
import os, pytest

@pytest.mark.parametrize('n', [1, 2])
def test_it(n):
    assert n == 1 or os.environ['NUMBA_DISABLE_JIT'] == '0', 'a - b'

@pytest.mark.compiled
def test_compiled():
    assert os.environ['NUMBA_DISABLE_JIT'] == '1'
"""


@pytest.mark.slow
def test_what_notices_a_mutant_is_the_test_that_fails():
    file = mutants.project() / "tests" / "test_air.py"  # a stem of the tests that pass as plain Python
    file.write_text(FAILING)
    try:
        plain, compiled = (*PYTEST, PLAIN, str(file)), (*PYTEST, COMPILED, str(file))
        alone = (*PYTEST, PLAIN, "tests/test_air.py::test_it[2]")
        compiled_alone = (*PYTEST, COMPILED, "tests/test_air.py::test_compiled")
        assert mutants.find_failure(plain) == ("caught", alone)
        assert mutants.find_failure(compiled) == ("caught compiled", compiled_alone)
        assert not mutants.passes_unchanged(alone)
        assert mutants.find_failure((*PYTEST, PLAIN, "tests/test_air.py::test_it[1]")) is None
        file.write_text("")
        assert mutants.find_failure(plain) is None
    finally:
        file.unlink()


def test_the_tests_of_a_module_begin_with_those_of_its_name():
    _, own, *_, compiled = mutants.tests_of("valve/piston.py")
    for command in (own, compiled):
        assert [Path(word).name for word in command if word.endswith(".py")] == ["test_piston.py"]
    assert (COMPILED in own, COMPILED in compiled) == (False, True)
    # A module whose name no test has.
    assert len(list(mutants.tests_of("apesim/march/dormand_prince.py"))) == 3
