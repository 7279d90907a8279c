"""`apesim machine`: what it prints reads back, and what it checks it says."""

import json
from pathlib import Path

import pytest

from apesim.engine.machine import Machine


def test_the_check_names_what_a_changed_stroke_leaves_behind_and_is_done(apesim):
    Path("m.toml").write_text('[valve]\nstroke = "6 mm"\npiston_diameter = "30 mm"\n')
    code, out, _ = apesim("machine", "--check", "m.toml")
    assert code == 0 and out.splitlines()[-1] == "m.toml: good"
    for part in ("valve.stroke", "valve.piston_area", "valve.moving_mass = 0.1145 kg", "groove.lap = 1 mm"):
        assert part in out
    code, out, _ = apesim("machine", "--check", "m.toml", "--json")
    data = json.loads(out)
    assert code == 0 and data["good"] is True
    [row] = [row for row in data["hints"] if row["key"] == "groove.lap"]
    assert row["value"] == "1 mm" and row["changed"] == ["valve.stroke"] and row["reason"]


@pytest.mark.parametrize("text", ["", '[engine]\nintake = "cam"\n[supply]\npressure = "0.8 MPa gauge"\n'])
def test_a_file_that_changes_no_size_gets_no_hint(apesim, text):
    Path("m.toml").write_text(text)
    assert apesim("machine", "--check", "m.toml")[1] == "m.toml: good\n"


def test_the_short_machine_is_read_and_is_the_machine_that_it_was_printed_from(apesim):
    code, short, _ = apesim("machine", "--short")
    assert code == 0 and len(short.splitlines()) < 50
    Path("short.toml").write_text(short)
    assert apesim("machine", "--machine", "short.toml")[1] == Machine().to_toml()
    setting = "valve.viscous_friction=90 N s/m"
    Path("other.toml").write_text(apesim("machine", "--short", "--set", setting)[1])
    assert apesim("machine", "--machine", "other.toml")[1] == apesim("machine", "--set", setting)[1]


def test_print_and_check_together_are_refused(apesim):
    code, out, err = apesim("machine", "--short", "--check", "m.toml")
    assert (code, out) == (2, "") and "--short" in err
