"""Dialogue: the questions, asked on a terminal, each until its answer can be used."""

from collections.abc import Callable, Mapping
from math import pi
from typing import Any

from apesim.engine.angles import RPM
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.quantities.settings import differences
from apesim.quantities.trees import schema
from apesim.restriction import AREA_OF_CONDUCTANCE
from apesim.studies.design.machine_design import EQ_8_RATIO, design_machine
from apesim.studies.design.questions import DISCHARGE, QUESTIONS, REPLACED, Question, declarations
from apesim.studies.discharge.records import read_tests

Ask = Callable[[str], str]
"""Function that shows a text and returns the line that is typed; raises EOFError where there is none."""
Tell = Callable[[str], object]
"""Function that shows a line."""


def find_open(machine: Machine, found: Mapping[str, Any]) -> list[Question]:
    """Find the questions that are still to be asked, in order, but for those that other answers replace.

    What a `machine` says other than the default one is answered.

    >>> [question.name for question in find_open(Machine().with_(engine_bore="60 mm"), {})][5]
    'stroke'
    """
    said = {key for key, _ in differences(machine)}
    by_test = bool(found.get(DISCHARGE[0].name))
    idle = {DISCHARGE[1].name} if not by_test else REPLACED
    idle = idle | {"critical_ratio"} if "valve.solenoid.effective_area" in said else idle
    order = (*QUESTIONS[:-4], *DISCHARGE, *QUESTIONS[-4:])
    return [each for each in order if each.name not in found and each.name not in idle and each.key not in said]


def ask_all(machine: Machine, answers: Mapping[str, Any], ask: Ask, tell: Tell) -> dict[str, Any]:
    """Ask all questions that have no answer yet, and return the answers by name; Enter leaves one to its default.

    The default that is shown follows from the answers so far.
    """
    found: dict[str, Any] = dict(answers)
    asked: set[str] = set()
    tell("Enter takes what stands in brackets. Give numbers with their unit. Ctrl-C ends, and writes nothing.")
    while left := [question for question in find_open(machine, found) if question.name not in asked]:
        asked.add(left[0].name)
        answer = _ask_one(left[0], machine, found, ask, tell)
        if answer:
            found[left[0].name] = answer
    return found


def _ask_one(question: Question, machine: Machine, found: Mapping[str, Any], ask: Ask, tell: Tell) -> Any:
    """Ask a question until its answer can be used; "" takes the default."""
    prompt = _prompt(question, machine, found)
    while True:
        answer = ask(prompt).strip()
        if not answer and question is not DISCHARGE[1]:
            return answer
        try:
            if question is DISCHARGE[0]:
                read_tests([answer], design_machine(machine, **found).machine.ambient.pressure)
                return [answer]
            # All is designed with the answer in it: that finds, too, what does not go with those before.
            design_machine(machine, **{**found, question.name: answer})
            return answer
        except InputError as error:
            for fault in error.faults:
                tell(f"  {fault.wrong}; {fault.right}")


def _prompt(question: Question, machine: Machine, found: Mapping[str, Any]) -> str:
    """What is asked, with the range and the default that follows from the answers so far."""
    if question is DISCHARGE[0]:
        return f"{question.text} [none]: "
    declaration = declarations()[question.name]
    if question is DISCHARGE[1]:
        return f"{question.text}, {declaration.range_text}: "
    return f"{question.text}, {declaration.range_text} [{default_of(question, machine, found)}]: "


def default_of(question: Question, machine: Machine, found: Mapping[str, Any]) -> str:
    """Return the text of what holds where a question is not answered, after the answers so far.

    >>> default_of(QUESTIONS[10], Machine(), {"bore": "20 mm", "stroke": "20 mm", "rated_speed": "3000 rpm"})
    '1.749 mm'
    """
    design = design_machine(machine, **found)
    made, declaration = design.machine, declarations()[question.name]
    if question.name == "rated_speed":
        return f"{design.rated_speed / RPM:g} rpm"
    if question.name == "critical_ratio":
        return f"{EQ_8_RATIO:g}"
    if question.name == "conductance":
        return f"{1e8 * made.valve.solenoid.effective_area / AREA_OF_CONDUCTANCE:.3g} {declaration.unit}"
    if question.name == "piston_diameter":
        return f"{2e3 * (made.valve.piston_area / pi) ** 0.5:.4g} mm"
    if question.name == "control_pressure":
        return declarations()["supply_pressure"].render(made.supply.control().pressure, made.ambient.pressure)
    value = next(leaf.default for leaf in schema(Machine, made) if leaf.key == question.key)
    return declaration.render(value, made.ambient.pressure)
