"""The pages on the missing effect: each verdict, key and effect has its place, and every sealed case is counted."""

import re

import apesim
from apesim.studies.gap.example_bench import explain_example
from apesim.studies.gap.reasons import Verdict
from docs.extensions.generated import write_effects, write_measured
from docs.results import benchmark
from tests.folders import ROOT
from tests.truth.scoring.score import NO_VERDICT, Scored
from tests.truth.sealed.second_schedule import second_plan

PAGES = ROOT / "docs" / "missing_effect"
CELL = re.compile(r"(?<!\\)\|")
"""A bar that divides the cells of a table."""


def cells_of(text):
    """Number of cells in each row of the tables of a page."""
    return {len(CELL.findall(line)) - 1 for line in text.splitlines() if line.startswith("|")}


def test_every_verdict_has_a_section():
    headings = re.findall(r"^## ([A-Z_]+)$", (PAGES / "verdicts.md").read_text(), re.MULTILINE)
    assert headings == [
        *("NO_GAP", "NAMED", "NAMED_CLASS", "TWO_EFFECTS", "SEVERAL", "AMBIGUOUS"),
        *("CALIBRATION", "MEASUREMENT", "REFUSED"),
    ]
    assert set(headings) == set(Verdict)


def test_every_key_of_a_verdict_is_explained():
    page = (PAGES / "index.md").read_text()
    table = page.partition("### How to read verdict.json")[2].partition("###")[0]
    explained = {
        key for row in re.findall(r"^\| (`[^|]*) \|", table, re.MULTILINE) for key in re.findall(r"`(\w+)`", row)
    }
    assert explained == {*explain_example().to_dict(), "next_test"}


def test_every_effect_has_a_section_with_its_parameters():
    text = write_effects()
    sections = dict(re.findall(r"^### (\w+)\n(.*?)(?=^###? |\Z)", text, re.MULTILINE | re.DOTALL))
    library = apesim.list_effects()
    assert set(sections) == set(library)
    assert set(re.findall(r"\]\(#(\w+)\)", text)) == set(library)
    for name, entry in library.items():
        assert f"`{entry.parameters[0].name}`" in sections[name]
    assert cells_of(text) == {6}


def test_nodes_of_a_table_share_a_row():
    assert "| `force_at_0` … `force_at_100` (11 nodes) | N | -40 to 40 N |" in write_effects()


def test_keys_of_measured_runs_are_explained():
    text = write_measured()
    assert "| `pulse`, **required** | 0.01 to 60000 ms | time for which the solenoids are energised |" in text
    assert '| `lift` | `lift [mm]` | `[sensor.lift]` `noise = "0.03 mm"` |' in text
    assert cells_of(text) == {3}


def test_a_case_without_a_verdict_counts():
    seeds = range(benchmark.FIRST, benchmark.FIRST + 725)
    answers = [{"kind": second_plan(seed).kind, "hidden": [], "clutter": second_plan(seed).clutter} for seed in seeds]
    table = benchmark.count_verdicts([Scored(answer, {"verdict": NO_VERDICT}) for answer in answers])
    counts = {row[0]: [cell.value for cell in row[1:]] for row in table.rows}
    assert counts["no verdict"] == counts["all"]
    assert sum(counts["all"]) == len(seeds) == 725
    assert all(row == [0] * len(benchmark.KINDS) for name, row in counts.items() if name not in ("no verdict", "all"))
