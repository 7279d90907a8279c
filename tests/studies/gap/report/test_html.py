"""The report of a verdict: its numbers, its maps, the page and the command that writes it."""

import json
import re
import sys
import tomllib
from types import SimpleNamespace

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.quantities.settings import dumps
from apesim.studies.commands.gap import explain
from apesim.studies.estimation.residuals import Block
from apesim.studies.gap.decide.operating_points import label_point
from apesim.studies.gap.example_bench import explain_example
from apesim.studies.gap.figures import draw_gap
from apesim.studies.gap.report import html
from apesim.studies.gap.report.chances import list_chances
from apesim.studies.gap.report.comparison import ComparedSignal, find_display, find_rms, group_by_run, select_worst
from apesim.studies.gap.report.html import MAX_WARNINGS, TERMS, TriedCandidate
from apesim.studies.gap.report.residual_map import map_residuals
from apesim.studies.gap.search.candidates import Probe
from apesim.studies.gap.search.file_numbers import find_file_numbers
from apesim.studies.gap.search.library import list_effects
from apesim.studies.gap.search.model_selection import PricedModel
from apesim.studies.measured import Measured, MeasuredRun
from apesim.studies.measured.lineage import read_parent
from apesim.studies.terminal.console import Console
from tests.gap_bench import write_bench

AMBIENT = 101325.0
MARKS = {
    "energise": 0.0,
    "release": 0.040,
    "opening_start": 0.005,
    "opening_contact": 0.010,
    "closing_start": 0.045,
    "closing_contact": 0.050,
}


def compared(role="fit", left=0.0, sensor="lift", number=0, marks=MARKS, after=True):
    """A signal of 100 ms with a constant left-over."""
    times = np.arange(0.0, 0.1, 0.5e-3)
    values = np.zeros(len(times))
    run = MeasuredRun("p", "p.csv", 0.4e6 + AMBIENT, 287.0, 0.04, role, times, {sensor: values})
    rest = np.full(len(times), left)
    block = Block(number, run, sensor, times, values, 0.5e-3)
    return ComparedSignal(block, 1e-5, values, values if after else None, rest, 0.1 * rest if after else None, marks)


def test_a_map_has_the_mean_of_each_cell_in_its_own_deviations():
    found = map_residuals([compared(left=0.5)])
    sizes = dict.fromkeys(name for name, _ in found.sections)
    assert list(sizes) == ["dead time", "opening", "dwell", "closing", "rest"]
    assert sum(columns for _, columns in found.sections) == found.before.shape[1]
    # 200 samples of 0.5 each in cells of n: sums of squares add up to 200 * 0.5^2.
    assert not np.isnan(found.before).any()
    assert np.sum(found.before**2) == pytest.approx(200 * 0.25)
    assert np.nansum(found.after**2) == pytest.approx(200 * 0.25 * 0.01)


def test_rows_of_a_map_share_their_phases_whatever_the_timing():
    late = {name: 1.2 * at for name, at in MARKS.items()}
    one, other = compared(left=0.0), compared(left=0.0, number=1, marks=late)
    for signal in (one, other):
        flying = (signal.block.times >= signal.marks["opening_start"]) & (
            signal.block.times < signal.marks["opening_contact"]
        )
        signal.residuals_before[flying] = 3.0
    found = map_residuals([one, other])
    ends = np.cumsum([0, *(columns for _, columns in found.sections)])
    opening = np.arange(found.before.shape[1])
    opening = (opening >= ends[1]) & (opening < ends[2])
    assert [name for name, _ in found.sections][1] == "opening"
    assert np.all(found.before[:, opening] >= 3.0)
    assert np.nansum(np.abs(found.before[:, ~opening])) == 0.0


def test_a_mark_that_never_comes_leaves_no_sample_out():
    turned = MARKS | {"opening_contact": np.nan, "closing_contact": np.nan}
    found = map_residuals([compared(left=1.0, marks=turned)])
    assert np.nansum(found.before**2) == pytest.approx(200.0)


def test_the_worst_are_of_runs_never_used_and_of_each_signal_once():
    signals = [
        compared("fit", 9.0),
        compared("check", 1.0, number=1),
        compared("check", 2.0, number=2),
        compared("check", 0.5, "pressure_a", 2),
    ]
    found = select_worst(signals, 3)
    assert [(one.role, one.block.sensor, find_rms([one.residuals_before])) for one in found] == [
        ("check", "lift", 2.0),
        ("check", "pressure_a", 0.5),
        ("check", "lift", 1.0),
    ]
    assert [len(own) for own in group_by_run(signals)] == [1, 1, 2]


def test_values_are_shown_in_the_unit_of_the_sensor():
    shown = find_display(compared().block)
    assert (shown.name, shown.unit, shown.convert(0.009)) == ("lift", "mm", pytest.approx(9.0))
    assert label_point(compared().block.run, AMBIENT) == "0.40 MPa gauge, 40 ms"


@pytest.mark.slow
def test_figures_have_the_same_bytes_each_time(tmp_path):
    signals = [compared("check", 2.0), compared("fit", 1.0, number=1)]
    rows = [TriedCandidate("side_force", 20.0, 21.0), TriedCandidate("bounce", 3.0, None)]
    drawn = []
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        svg = draw_gap(signals, rows, "with side force", AMBIENT, tmp_path / name)
        drawn.append((svg, {path.name: path.read_bytes() for path in (tmp_path / name).iterdir()}))
    assert drawn[0] == drawn[1]
    assert sorted(drawn[0][1]) == sorted(f"{name}.{kind}" for name in drawn[0][0] for kind in ("pdf", "png"))


def test_figures_are_drawn_where_nothing_was_added(tmp_path):
    assert (
        len(draw_gap([compared(left=1.0, after=False)], [TriedCandidate("bounce", 1.0, None)], "", AMBIENT, tmp_path))
        == 4
    )
    assert "candidates" not in draw_gap([compared(left=1.0, after=False)], [], "", AMBIENT, tmp_path)


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    return write_bench(tmp_path_factory.mktemp("bench"))


@pytest.mark.slow
def test_the_command_leaves_a_page_that_stands_alone(apesim, bench, tmp_path):
    code, out, err = apesim("gap", "explain", str(bench), "--out", "found", "--json", "--quiet")
    assert (code, err) == (0, "")
    told = json.loads(out)
    text = (tmp_path / "found" / "verdict.json").read_text()
    assert json.loads(text) == told
    assert "NaN" not in text
    assert "Infinity" not in text
    assert told["verdict"] in ("NAMED", "NAMED_CLASS", "AMBIGUOUS")
    assert "side_force" in str(told["effects"] or told["nearest"])
    page = (tmp_path / "found" / "report.html").read_text()
    assert told["sentence"].replace("^2", "²") in page
    assert all(digest in page for digest in told["lineage"].values())
    assert not re.findall(r"""(?:src|href)=["'](?!data:)|url\(|<script|@import""", page)
    assert page.count("data:image/svg+xml;base64,") == 4
    assert all(sentence in page for sentence in list_chances(told))
    assert "probability" not in (tmp_path / "found" / "machine.toml").read_text()
    child = tomllib.loads((tmp_path / "found" / "machine.toml").read_text())
    assert child["valve"]["stroke"] == "9 mm"
    assert sorted(path.suffix for path in (tmp_path / "found" / "figures").iterdir()) == [".pdf"] * 4 + [".png"] * 4
    space = {path.name: path.read_text() for path in (tmp_path / "found" / "petab_select").iterdir()}
    assert len(space) == 5
    assert "\nside_force\t" in space["model_space.tsv"]
    assert '\n  model_id: "side_force"\n' in space["calibrated_models.yaml"]
    code, _, err = apesim("gap", "explain", str(bench), "--out", "found")
    assert (code, err) == (2, "found: is not empty; choose another --out, or give --overwrite\n")


def page_of(**more):
    """A page of a refusal."""
    data = {
        "verdict": "REFUSED",
        "sentence": "<script>alert(1)</script>",
        "reason": "<b>",
        "probability": None,
        "inclusion": {},
        "scatter": [],
        "p_value": 0.001,
        "effects": [],
        "sure": [],
        "numbers": [],
        "alternatives": [],
        "nearest": [],
        "warnings": ["<i>p.csv</i>"],
        "detection_limits": {},
        "nuisances": [],
        "noise": [],
        "lineage": {},
        "held_out": None,
        "own_error": 1e-6,
        "likely_cause": {"text": "<u>", "before": 3.1, "after": 1.0, "samples": 40, "why_not": "<u>"},
    }
    data |= more
    base = SimpleNamespace(residuals=SimpleNamespace(machine=Machine()), cost=1.0)
    explanation = SimpleNamespace(calibrated=base, measured=Measured("", {}, ()), ranked=[], fits=[])
    return html.render_page(explanation, data, [compared(after=False)], {"gap": "<svg/>"})


@pytest.mark.parametrize(
    ("open_ends", "told"), [([], "20 N."), (["low"], "at most 25 N."), (["low", "high"], "not held by these data.")]
)
def test_what_comes_nearest_is_told_as_far_as_the_data_hold_it(open_ends, told):
    row = {"name": "coulomb_friction", "parameter": "breakaway", "key": "effects.coulomb_friction.breakaway"}
    row |= {"value": 20.0, "unit": "N", "interval_95": [0.0, 25.0], "open_ends": open_ends}
    assert f"coulomb friction, breakaway {told}" in page_of(nearest=[row])


CHANCES = {"probability": 0.934, "inclusion": {"side_force": 0.9999, "leakage_a or leakage_b": 0.031, "bounce": None}}
SENTENCES = (
    "Of sealed cases with such a statement, 93 in 100 were right.",
    "Part of what is missing, by such evidence on sealed cases: side_force in 99 of 100, leakage_a or leakage_b in 3.",
)


def test_a_page_says_how_often_such_statements_were_right_or_that_nothing_tells():
    assert all(sentence in page_of(**CHANCES) for sentence in SENTENCES)
    assert "too few sealed cases tell of such statements" in page_of()
    assert "it claims nothing" in page_of(verdict="AMBIGUOUS")


def test_the_terminal_says_the_same():
    shown = list(explain._shown(explain_example().to_dict() | CHANCES))
    assert set(SENTENCES) < {each for each in shown if isinstance(each, str)}


def test_what_is_sure_of_an_ambiguous_gap_stands_on_page_and_terminal_with_its_interval():
    row = {"name": "side_force", "parameter": "force", "key": "effects.side_force.force", "class": ["bounce"]}
    row |= {"value": 3.1, "unit": "N", "interval_95": [2.54, 3.75], "open_ends": []}
    page = page_of(verdict="AMBIGUOUS", sure=[row])
    shown = [each for each in explain._shown(explain_example().to_dict() | named_cause(row)) if isinstance(each, str)]
    # Neither calls the whole of it a mere hint, or no claim.
    assert "it claims nothing" not in page
    assert all("But for what is sure" in said for said in (page, " ".join(shown)))
    assert "But for what is sure" not in page_of(verdict="AMBIGUOUS")
    for said in (visible(page), *(each for each in shown if each.startswith("Sure"))):
        assert all(text in said for text in ("3.1 N", "side force, force", "2.5 to 3.8 N", "bounce"))
    assert sum(each.startswith("Sure") for each in shown) == 1


def named_cause(row):
    """What a verdict holds that has one effect for sure."""
    cause = {"text": "side force with bounce", "before": 3.1, "after": 1.0, "samples": 40, "why_not": "several"}
    return {"verdict": "AMBIGUOUS", "sure": [row], "likely_cause": cause}


def test_a_calibrated_number_that_runs_state_is_shown_as_a_shift_and_others_before_and_after():
    rows = [
        {"key": "supply.pressure", "before": None, "value": None, "unit": "MPa", "shift": 0.81, "shift_unit": "%"},
        {"key": "valve.viscous_friction", "before": 114.0, "value": 117.4, "unit": "N s/m", "shift": None},
    ]
    rows = [row | {"error": error} for row, error in zip(rows, (0.02, 3.0), strict=True)]
    known = [{"known_to": "1 %", "stated_in": "default"}, {"known_to": "5 N s/m", "stated_in": "measured.toml"}]
    pulled = {"deviations": 0.8, "deviations_error": 0.3, "apart": None}
    page = page_of(nuisances=[row | own | pulled for row, own in zip(rows, known, strict=True)])
    assert "<td>as each run states</td><td>that +0.81 %</td>" in page
    assert "<td>114 N s/m</td><td>117 N s/m</td>" in page
    assert "<td>1 %</td>" in page
    assert "<td>5 N s/m, stated</td>" in page
    assert "They are not in\n<code>machine.toml</code>" in page  # of a refusal
    assert "Those of the machine are in <code>machine.toml</code>" in page_of(verdict="NO_GAP")


def test_a_size_from_which_an_area_is_visible_says_that_smaller_ones_are_the_larger_effect():
    limit = {
        "parameter": "feed_area",
        "unit": "mm^2",
        "limit": 12.0,
        "off": 0.0,
        "grows": "down",
        "kept": 0.5,
        "class": [],
    }
    assert "<td>12 mm² and below</td>" in page_of(detection_limits={"supply_droop": limit})


def test_a_number_of_the_file_that_the_data_never_show_is_told_with_the_range_that_was_tried():
    numbers = find_file_numbers(Machine(), Measured("", {}, (), "engine"), [])
    probes = [Probe(number, (0.1,), 0) for number in numbers]
    explanation = SimpleNamespace(
        calibrated=SimpleNamespace(residuals=SimpleNamespace(machine=Machine())),
        sensitivities=[SimpleNamespace(probe=probe) for probe in probes],
    )
    ranges = html.find_ranges(explanation, ["valve.stroke", "engine.exhaust.opens", "bounce"])
    stroke = Machine().valve.stroke * 1e3
    assert ranges["valve.stroke"] == f"{0.4 * stroke:.3g} to {1.6 * stroke:.3g} mm"
    assert ranges["engine.exhaust.opens"].endswith(" deg")
    assert ranges["bounce"] == list_effects()["bounce"].parameters[0].range


NEXT_TEST = {
    "text": "again",
    "truth": "coulomb_friction",
    "isolate": [{"effect": "bounce", "isolated_by": "a high-speed sensor"}],
    "experiments": [
        {
            "text": "a run at 1.0 MPa gauge",
            "deviations": {"spring_rate_error": 7.25, "moving_mass_error": 6.5},
            "settled": 0.874,
            "outcomes": [
                {
                    "explanation": name,
                    "quantity": "mean lift in dwell",
                    "unit": "mm",
                    "value": value,
                    "change": value and value - 9.0,
                    "deviations": n_sigma,
                    "decimals": 2,
                }
                for name, value, n_sigma in (("coulomb_friction", 8.7134, 12.3), ("none of the library", None, None))
            ],
        }
    ],
}


def test_each_column_of_the_next_test_is_headed_by_what_it_would_split_off():
    page = page_of(next_test=NEXT_TEST)
    assert "<th>spring rate error</th><th>moving mass error</th>" in page
    assert "<td>87&nbsp;%</td>" in page
    assert "<td>7</td><td>6</td>" in page


NEXT = {"text": "Weigh the piston.", "isolate": []}


def visible(page):
    """Text of a page, its folded parts left out."""
    body = page[page.index("<body>") :]
    return re.sub(r"<[^>]+>", " ", re.sub(r"<details(?! open)[^>]*>.*?</details>", "", body, flags=re.DOTALL))


def test_a_refusal_begins_with_the_cause_why_it_is_not_named_and_what_to_do():
    cause = {"text": "side force (force 3.1 N)", "before": 3.14159, "after": 1.04, "samples": 40}
    cause["why_not"] = "it fails at 0.7 MPa"
    page = visible(page_of(likely_cause=cause, next_test=NEXT))
    said = ["Most likely cause", "Side force (force 3.1 N).", "from 3.1 to 1.0 times the noise", "Why it is not named"]
    said += ["It fails at 0.7 MPa.", "Do this next", "Weigh the piston.", "p.csv"]
    places = [page.index(text) for text in said]
    assert places == sorted(places)
    assert page.count("Weigh the piston.") == 1


def test_a_refusal_folds_its_tables_and_other_verdicts_do_not():
    titles = "What was tried", "What was calibrated", "Where this comes from"
    assert not any(title in visible(page_of()) for title in titles)
    assert all(title in visible(page_of(verdict="NAMED", likely_cause=None)) for title in titles)
    assert "::details-content { content-visibility: visible" in page_of()  # on paper all is unfolded


def test_the_gap_stands_at_the_head_as_one_number_where_nothing_was_added():
    head = page_of(likely_cause=None).partition('<p class="terms">')[0]
    assert re.findall(r"<b>([^<]*)</b>", head) == ["0.00"] and "→" not in head


@pytest.mark.parametrize("number", [MAX_WARNINGS, MAX_WARNINGS + 4])
def test_at_most_three_warnings_are_shown_at_once(number):
    warnings = [f"warning number {k}" for k in range(number)]
    page = page_of(warnings=warnings)
    assert [text in visible(page) for text in warnings] == [k < MAX_WARNINGS for k in range(number)]
    assert all(text in page for text in warnings)
    assert (f"{number - MAX_WARNINGS} more warnings" in page) == (number > MAX_WARNINGS)


def test_each_term_is_explained_in_the_part_in_which_it_stands():
    row = {"key": "valve.viscous_friction", "before": 114.0, "value": 117.4, "unit": "N s/m", "error": 3.0}
    row |= {"known_to": "5 N s/m", "stated_in": "default", "deviations": 0.8, "deviations_error": 0.3, "apart": None}
    noise = {"sensor": "lift", "deviation": 2e-5, "order": 0, "hum_hz": [], "source": "repeats"}
    limit = {"parameter": "force", "unit": "N", "limit": 1.0, "off": 0.0, "grows": "up", "kept": 0.5, "class": []}
    page = page_of(
        nuisances=[row],
        noise=[noise],
        detection_limits={"side_force": limit},
        next_test=NEXT_TEST,
    )
    parts = [part for part in page.split("<h2>") if "</h2>" in part]
    used = {term: [part for part in parts if re.search(rf"\b{term}s?\b", part)] for term in TERMS}
    for term in ("sigma", "score", "penalised cost", "retained", "cosine", "known to", "pull", "white", "hum"):
        assert used[term] or term in ("score", "penalised cost")
        assert all(f"<dfn>{term}</dfn>: {TERMS[term]}"[:40] in part for part in used[term]), term


def test_the_next_test_says_what_each_outcome_would_mean():
    page = page_of(next_test=NEXT_TEST)
    assert "a run at 1.0 MPa gauge: if it is</th><th>mean lift in dwell [mm]</th>" in page
    assert "<tr><td>coulomb friction</td>\n<td>8.71</td><td>-0.29</td>\n<td>12</td></tr>" in page
    assert "<tr><td>none of the library</td>\n<td>-</td><td>-</td>\n<td>-</td></tr>" in page
    assert "bounce: a high-speed sensor." in page


def test_names_in_a_page_are_escaped():
    page = page_of()
    assert not any(text in page for text in ("<script>", "<b>.", "<i>", "<u>"))
    assert "&lt;script&gt;" in page


def test_costs_of_explanations_count_from_the_least_of_their_own_kind():
    """With runs that judge, what they leave is in the cost that decides, and it may turn the order."""

    def choice(name, cost):
        return PricedModel(SimpleNamespace(names=(name,), cost=cost), cost)

    def rows(role):
        run = compared(role).block.run
        tried = [choice("a", 50.0), choice("b", 52.0), choice("c", 90.0)]
        judged = [choice("b", 70.0), choice("a", 64.0)]
        base = SimpleNamespace(cost=150.0)
        return html.list_explanations(
            SimpleNamespace(calibrated=base, fits=tried, ranked=judged, measured=Measured("", {}, (run,)))
        )

    assert [(row["names"], row["cost"], row["judged"]) for row in rows("gate")] == [
        (["a"], 0.0, 0.0),
        (["b"], 2.0, 6.0),
        (["c"], 40.0, None),
    ]
    assert [(row["cost"], row["judged"]) for row in rows("check")] == [(0.0, None), (2.0, None), (40.0, None)]


def test_a_parent_is_the_file_unless_something_is_set_besides(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('# mine\n[valve]\nstroke = "8 mm"\n')
    plain, cut = (Machine.load(file, settings) for settings in ([], ["valve.stroke=7 mm"]))
    assert read_parent(plain, file, []) == file.read_text()
    assert read_parent(cut, file, ["valve.stroke=7 mm"]) == dumps(cut) != dumps(plain)
    assert read_parent(Machine(), None, []) == dumps(Machine())


@pytest.mark.parametrize(
    ("arguments", "wrong"),
    [
        (("nowhere", "--out", "x"), "measured.toml"),
        (("{bench}", "--out", "x", "--without", "fairies"), "fairies"),
        (("{bench}", "--out", "{bench}/measured.toml"), "cannot be made"),
        (("{bench}",), "--out"),
    ],
)
def test_bad_input_is_told_in_a_line(apesim, bench, arguments, wrong):
    code, out, err = apesim("gap", "explain", *(argument.format(bench=bench) for argument in arguments))
    assert (code, out) == (2, "")
    assert wrong in err
    assert "Traceback" not in err
    assert len(err.splitlines()) == 1


def test_a_simulation_that_does_not_end_is_told_and_kept_apart_from_bad_input(apesim, bench, monkeypatch):
    from apesim.studies.estimation import residuals

    monkeypatch.setattr(residuals, "predict", lambda *_: SimpleNamespace(failed=True))
    code, out, err = apesim("gap", "explain", str(bench), "--out", "failed")
    assert (code, out) == (3, "")
    assert err.startswith("p16.csv: the simulation does not come to its end; simulate its conditions with run_valve")
    assert err.endswith("; nothing is concluded\n")


def test_a_sensor_that_is_in_runs_to_check_alone_is_refused(apesim, tmp_path):
    folder = write_bench(tmp_path)
    header, *rows = (folder / "p49.csv").read_text().splitlines()
    lines = [f"{header},pressure_a [kPa abs]", *(f"{row},{500 + k % 7}" for k, row in enumerate(rows))]
    (folder / "p49.csv").write_text("\n".join(lines) + "\n")
    for command in (("explain", "--out", "x"), ("isolability",)):
        code, out, err = apesim("gap", command[0], str(folder), *command[1:])
        assert (code, out, len(err.splitlines())) == (2, "", 1)
        assert "p49.csv: pressure_a: is in runs to check alone" in err


def test_means_alone_are_drawn(tmp_path):
    run = compared().block.run._replace(bench="engine", speed=100.0, means={"torque": 30.0}, channels={})
    block = Block(0, run, "torque", np.zeros(1), np.array([30.0]), 0.0)
    mean = ComparedSignal(block, 0.3, np.array([31.0]), None, np.array([3.3]), None, {})
    assert sorted(draw_gap([mean], [TriedCandidate("bounce", 1.0, None)], "", AMBIENT, tmp_path)) == [
        "candidates",
        "gap",
        "maps",
    ]


def test_a_sensor_that_never_changes_is_refused(apesim, tmp_path):
    folder = write_bench(tmp_path)
    header, *rows = (folder / "p40.csv").read_text().splitlines()
    (folder / "p40.csv").write_text("\n".join([header, *(row.split(",")[0] + ",0" for row in rows)]) + "\n")
    code, out, err = apesim("gap", "explain", str(folder), "--out", "x")
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert "p40.csv: lift: never changes" in err


def test_stages_are_told_on_a_terminal_by_name(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with Console().stages("explaining") as report:
        for stage, whole in (("calibrating", 1), ("fitting effects", 7)):
            report(stage, whole, whole)
            shown = capsys.readouterr().err
    assert "fitting effects" in shown + capsys.readouterr().err
    with Console(quiet=True).stages("explaining") as report:
        report("calibrating", 0, 1)
    assert capsys.readouterr().err == ""
