"""A published engine run on air: C.-Y. Huang et al., Energies 2013, 6, 1731 (doi 10.3390/en6031731).

Little of it is published, so no error is demanded: ``docs/validation/huang.md`` shows what comes out, whatever it is,
and these tests keep its numbers those that are computed. ``-s`` prints its tables as they should stand.
"""

import json
import shlex
import sys
from itertools import pairwise
from math import pi

import pytest

from apesim.engine.indicators import indicators
from apesim.engine.machine import Machine
from apesim.studies.cli import app
from apesim.studies.console import main_of
from tests.folders import ROOT
from tests.machines import settled

EXAMPLES = ROOT / "docs" / "examples"
MACHINE, PAGE = EXAMPLES / "data" / "huang.toml", ROOT / "docs" / "validation" / "huang.md"
TORQUE_SPEED, POWER_SPEED = 465.0, 1320.0
TORQUE, POWER, COLDEST = 9.99, 0.95, 17.0
"""Published values: N m, kW, degrees Celsius."""
SPEEDS = range(300, 2401, 50)


def point(rpm, settings=()):
    machine = Machine.load(MACHINE, list(settings))
    run = settled(machine, rpm)
    return indicators(machine, run), run


def line(*cells):
    return "| " + " | ".join(cells) + " |"


def share(found, of):
    """What a number is more than another."""
    return f"{100.0 * (found / of - 1.0):+.1f} %"


def comparison():
    """Lines of the table of published and computed numbers."""
    lines = []
    for words, slow_settings, fast_settings in (
        ("", (), ()),
        (", outlet as measured", ['ambient.pressure="1.5 bar abs"'], ['ambient.pressure="1.9 bar abs"']),
    ):
        torque = point(TORQUE_SPEED, slow_settings)[0]["brake_torque_Nm"]
        power = point(POWER_SPEED, fast_settings)[0]["brake_power_W"] / 1e3
        lines += [
            line(f"brake torque at 465 r/min{words}", "9.99 N m", f"{torque:.2f} N m", share(torque, TORQUE)),
            line(f"brake power at 1320 r/min{words}", "0.95 kW", f"{power:.3f} kW", share(power, POWER)),
        ]
    best = max(SPEEDS, key=lambda rpm: point(rpm)[0]["brake_power_W"])
    lines.append(line("speed of the highest power", "1320 r/min", f"{best} r/min", f"{best - 1320:+d} r/min"))
    for words, settings in (("", ()), (", with Woschni's wall heat", ["effects.cylinder_wall_heat.factor=1"])):
        coldest = point(TORQUE_SPEED, settings)[1].trace[:, 1].min() - 273.15
        what = f"coldest air in the cylinder{words}"
        lines.append(line(what, "17 °C", f"{coldest:.0f} °C at 465 r/min", f"{coldest - COLDEST:+.0f} K"))
    return lines


def sensitivity(settings):
    """Cells of a row of the sensitivity table: torque and power, and their changes."""
    cells = []
    for rpm, name, factor, form, unit in (
        (TORQUE_SPEED, "brake_torque_Nm", 1.0, ".2f", "N m"),
        (POWER_SPEED, "brake_power_W", 1e-3, ".3f", "kW"),
    ):
        base, changed = (point(rpm, s)[0][name] * factor for s in ((), settings))
        cells.append(f"{changed:{form}} {unit} ({share(changed, base)})")
    return cells


def listed():
    """Rows of the page's sensitivity table: their lines, and their cells."""
    lines = PAGE.read_text().split("## What the assumptions are worth")[1].splitlines()
    return [
        (row, [cell.strip() for cell in row.strip("|").split("|")]) for row in lines if "`" in row and row[0] == "|"
    ]


def test_the_example_is_the_published_engine_as_far_as_it_is_published():
    machine = Machine.load(MACHINE)
    assert 0.25 * pi * machine.engine.bore**2 * machine.engine.stroke == pytest.approx(100e-6, rel=0.005)
    assert machine.supply.pressure == 9e5
    assert machine.engine.cam.lift == machine.valve.stroke == 2e-3


def test_the_command_of_the_page_runs(monkeypatch, capsys):
    command = f'apesim engine run --machine docs/examples/data/huang.toml --speed "{TORQUE_SPEED:g} rpm"'
    assert command in PAGE.read_text()
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(sys, "argv", [*shlex.split(command), "--json"])
    assert main_of(app) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["brake_torque_Nm"] == pytest.approx(point(TORQUE_SPEED)[0]["brake_torque_Nm"], rel=1e-12)


def test_the_page_shows_the_published_points_as_computed():
    lines = comparison()
    print(*lines, sep="\n")
    assert "\n".join(lines) in PAGE.read_text()


def test_the_page_shows_what_each_assumption_is_worth_as_computed():
    rows = listed()
    expected = [line(what, words, *sensitivity(shlex.split(words.strip("`")))) for _, (what, words, *_) in rows]
    print(*expected, sep="\n")
    assert len(rows) > 20
    assert [row for row, _ in rows] == expected
    torques, powers = ([float(row.split("|")[column].split()[0]) for row in expected] for column in (3, 4))
    text = " ".join(PAGE.read_text().split())
    assert f"from {min(torques):.1f} to {max(torques):.1f} N m" in text
    assert f"from {min(powers):.1f} to {max(powers):.1f} kW" in text


def test_torque_falls_with_speed_as_in_any_air_engine():
    torques = [point(rpm)[0]["brake_torque_Nm"] for rpm in SPEEDS]
    assert all(later < earlier for earlier, later in pairwise(torques))
