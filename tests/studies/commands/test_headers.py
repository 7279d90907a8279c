import re

import pytest

from apesim.studies.assessment import summary as assessment
from apesim.studies.commands.engine import limit as engine_limit
from apesim.studies.commands.valve import limit as valve_limit
from apesim.studies.commands.valve import map as valve_map
from apesim.studies.optimise import summary as optimise
from apesim.studies.soft_landing import summary as soft_landing
from apesim.studies.terminal.tables import table_of
from apesim.studies.timing import summary as timing

WORDS = {"stroke", "brake", "solenoids", "commands", "full lift", "then fails", ""}
"""Heads of columns that hold words."""
HEADERS = {
    "engine timing": [head for _, head, _ in timing.SHOWN],
    "engine optimise": optimise.HEADER,
    "engine limit": engine_limit.HEADER,
    "engine assess": [*assessment.LATE_HEADINGS, *(name for *_, name in assessment.BESIDE)],
    "valve map": valve_map.HEADER,
    "valve limit": [name for name in valve_limit.HEADER if name != "duty"],
    "valve soft-landing": soft_landing.BRAKE_HEADER,
}


@pytest.mark.parametrize("command", HEADERS)
def test_every_column_of_numbers_says_its_unit(command):
    without = [head for head in HEADERS[command] if not re.search(r"\[.+\]|^(K|MPa gauge|r/min)$", head)]
    assert set(without) <= WORDS


def test_a_name_too_long_for_its_column_is_broken_not_cut():
    from rich.console import Console

    console = Console(width=30)
    with console.capture() as captured:
        console.print(table_of("", ("name", "value"), [("exhaust_back_flow_kg_per_cycle_of_it", "1.0")]))
    assert "…" not in captured.get()
