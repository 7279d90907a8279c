import re

import pytest

from apesim.studies.commands import assessment, engine_limit, optimise, soft_landing, timing, valve_grid
from apesim.studies.commands.tables import table_of

WORDS = {"stroke", "brake", "solenoids", "commands", "full lift", "then fails", ""}
"""Heads of columns that hold words."""
HEADERS = {
    "engine timing": [name for *_, name in timing.SHOWN],
    "engine optimise": optimise.HEADER,
    "engine limit": engine_limit.HEADER,
    "engine assess": [*assessment.LATE_HEADINGS, *(name for *_, name in assessment.BESIDE)],
    "valve map": valve_grid.MAP_HEADER,
    "valve limit": [name for name in valve_grid.LIMIT_HEADER if name != "duty"],
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
