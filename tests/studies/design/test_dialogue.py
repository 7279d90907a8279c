"""Questions on a terminal: each is asked until its answer can be used, and nothing is half done."""

import pytest

from apesim import Machine, design_machine
from apesim.studies.design.dialogue import ask_all, find_open
from apesim.studies.design.questions import DISCHARGE, QUESTIONS
from tests.folders import ROOT


class Builder:
    """Somebody who answers; what is not in `answers`, by a word of the question, is Enter."""

    def __init__(self, **answers):
        self.answers = {key: list(value) for key, value in answers.items()}
        self.prompts, self.told = [], []

    def ask(self, prompt):
        self.prompts.append(prompt)
        for key, lines in self.answers.items():
            if prompt.startswith(key.replace("_", " ")) and lines:
                return lines.pop(0) + "\n"
        return "\n"


def test_enter_to_all_is_the_default_machine():
    builder = Builder()
    assert ask_all(Machine(), {}, builder.ask, builder.told.append) == {}
    assert len(builder.prompts) == len(QUESTIONS) + 1  # and whether there is a discharge test


def test_a_wrong_answer_is_met_with_the_right_form_and_asked_again():
    builder = Builder(bore=["20", "2 m", "20 mm"], pressure_of_the_supply=["1 MPa", "0.8 MPa gauge"])
    answers = ask_all(Machine(), {}, builder.ask, builder.told.append)
    assert answers == {"supply_pressure": "0.8 MPa gauge", "bore": "20 mm"}
    told = "\n".join(builder.told)
    assert '"20 mm"' in told and "5 to 1000 mm" in told and '"1 MPa gauge"' in told


def test_each_question_shows_unit_range_and_the_default_that_follows_from_the_answers():
    builder = Builder(bore=["20 mm"], stroke=["20 mm"], rated=["3000 rpm"])
    answers = ask_all(Machine(), {}, builder.ask, builder.told.append)
    [prompt] = [prompt for prompt in builder.prompts if prompt.startswith("stroke of the intake valve")]
    stroke = 1e3 * design_machine(**answers).machine.valve.stroke
    assert "0.5 to 100 mm" in prompt and f"[{stroke:g} mm]" in prompt


def test_a_discharge_test_takes_the_place_of_four_questions():
    tests = ROOT / "docs" / "examples" / "data" / "discharge"
    builder = Builder(CSV=["no.csv", str(tests / "p040.csv")], volume_of_the_vessel=["", "100 cm^3"])
    answers = ask_all(Machine(), {}, builder.ask, builder.told.append)
    assert answers == {"discharge_test": [str(tests / "p040.csv")], "vessel_volume": "100 cm^3"}
    assert len(builder.prompts) == len(QUESTIONS) - 4 + 4  # both were asked twice
    assert len(builder.told) == 3 and "no.csv" in builder.told[1]


def test_what_the_machine_says_already_is_not_asked():
    asked = {question.name for question in find_open(Machine().with_(valve_solenoid_effective_area="5 mm^2"), {})}
    assert not {"conductance", "critical_ratio"} & asked and {"dead_time", "bore"} <= asked
    assert find_open(Machine(), {question.name: "" for question in (*QUESTIONS, DISCHARGE[0])}) == []


def test_the_end_of_the_answers_ends_the_dialogue():
    def ask(prompt):
        raise EOFError

    with pytest.raises(EOFError):
        ask_all(Machine(), {}, ask, print)
