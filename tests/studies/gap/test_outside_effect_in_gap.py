"""The missing-effect workflow with an effect from outside, on data of the independent simulator."""

import json

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.gap.search.candidates import find_candidates
from apesim.studies.gap.search.library import find_faults, list_effects, select_effects
from apesim.studies.measured import Measured, read_measured
from apesim.studies.measured.arguments import open_measured
from tests.folders import ROOT
from tests.truth.simulator.terms import FORCE
from tests.truth.simulator.valve import Bench, noise, simulate

EXAMPLE = ROOT / "docs" / "examples" / "data" / "tapered_bore.py"
AMBIENT = 101325.0
HIDDEN = 80.0
"""Strength of the tapered bore that is hidden [N s/m]."""
PRESSURES = {0.16: "fit", 0.40: "fit", 0.70: "fit", 0.55: "gate", 0.49: "check"}
"""[MPa gauge]"""
TIMES = np.linspace(0.0, 0.1, 501)


@pytest.fixture(scope="module")
def machine():
    return Machine().with_effects(EXAMPLE)


def write_rig(folder, friction):
    """Data of the independent simulator, with the tapered bore as a force of its own."""

    def taper(now, sums):
        sums[FORCE] -= friction * (1.0 - now.position / 9e-3) * now.speed

    rng = np.random.default_rng(5000)
    text = 'bench = "valve"\n[sensor.lift]\nnoise = "0.03 mm"\n'
    for pressure, role in PRESSURES.items():
        rig = Bench(supply_pressure=pressure * 1e6 + AMBIENT, terms=(taper,))
        states = simulate(rig, 50e-3, float(TIMES[-1])).states(TIMES)
        columns = {
            "time [s]": TIMES,
            "lift [m]": rig.stroke - states[0] + noise(len(TIMES), 0.03e-3, rng),
            "pressure_a [Pa abs]": states[2] + noise(len(TIMES), 2e3, rng),
            "pressure_b [Pa abs]": states[4] + noise(len(TIMES), 2e3, rng),
        }
        rows = "".join(",".join(map(repr, map(float, row))) + "\n" for row in zip(*columns.values(), strict=True))
        name = f"p{100 * pressure:03.0f}.csv"
        (folder / name).write_text(",".join(columns) + "\n" + rows)
        text += f'[[run]]\ndata = "{name}"\nsupply = "{pressure} MPa gauge"\ntemperature = "287 K"\n'
        text += f'pulse = "50 ms"\nrole = "{role}"\n'
    (folder / "measured.toml").write_text(text)
    return folder


def test_it_stands_in_the_library_of_its_machine_and_of_no_other(machine):
    (entry,) = (entry for entry in list_effects(machine).values() if entry.name == "tapered_bore")
    assert (entry.layer, entry.slots, entry.file) == ("valve", ("law",), "tapered_bore.py")
    (parameter,) = entry.parameters
    assert (parameter.name, parameter.unit, parameter.range) == ("friction", "N s/m", "0 to 200 N s/m")
    assert "tapered_bore" not in {entry.name for entry in list_effects().values()}
    for bench in ("valve", "engine"):
        assert "tapered_bore" in {effect.name for effect in select_effects(bench, (), machine)}
        assert "tapered_bore" not in {effect.name for effect in select_effects(bench, ("tapered_bore",), machine)}


def test_it_is_a_candidate_with_its_own_range_and_unit(machine):
    found = {one.name: one for one in find_candidates(machine, "valve", select_effects("valve", (), machine))}
    (parameter,) = found["tapered_bore"].parameters
    assert parameter.value(parameter.ends[1]) == 200.0
    assert parameter.shown(60.0) == 60.0 and parameter.declaration.unit == "N s/m"
    assert parameter.is_marched
    ours = {one.name: one for one in find_candidates(Machine(), "valve", select_effects("valve"))}
    assert {name: one for name, one in found.items() if name != "tapered_bore"} == ours


def test_its_name_may_be_left_out_where_the_machine_has_it(machine):
    assert find_faults(["tapered_bore"], machine) == []
    ((_, wrong, _),) = find_faults(["tapered_bore"], Machine())
    assert wrong == "'tapered_bore' is no effect"


def test_a_machine_with_one_is_taken_beside_measured_data(machine):
    measured = Measured("", {}, ())
    assert open_measured("explain", machine, measured)[1] is measured
    wrong = machine._replace(valve=machine.valve._replace(stroke=-1.0))
    with pytest.raises(InputError, match=r"explain\(\): valve\.stroke"):
        open_measured("explain", wrong, measured)


def test_a_measured_folder_cannot_name_one(tmp_path):
    text = 'bench = "valve"\n[effects]\nfiles = ["tapered_bore.py"]\n'
    (tmp_path / "tapered_bore.py").write_text("raise SystemExit('it was run')\n")
    (tmp_path / "measured.toml").write_text(text)
    with pytest.raises(InputError, match="effects: unknown key"):
        read_measured(tmp_path, AMBIENT)


def told_by(apesim, *arguments):
    """Exit code of a command, and what it tells as JSON."""
    code, out, _ = apesim(*map(str, arguments), "--json")
    return code, json.loads(out)


@pytest.mark.slow
def test_it_is_named_with_its_file_and_refused_without(tmp_path, apesim):
    """The strength lies in its interval, and the machine file that is written names the file again."""
    folder = tmp_path / "measured"
    folder.mkdir()
    write_rig(folder, HIDDEN)
    code, told = told_by(apesim, "gap", "explain", folder, "--effect-file", EXAMPLE, "--out", "found")
    assert code == 0
    assert (told["verdict"], [row["name"] for row in told["effects"]]) == ("NAMED", ["tapered_bore"])
    (row,) = told["effects"]
    low, high = row["interval_95"]
    assert low < HIDDEN < high and (row["unit"], high - low < 40.0) == ("N s/m", True)
    assert told["held_out"]["size_after"] < 0.15 < told["held_out"]["size_before"]
    child = Machine.load(tmp_path / "found" / "machine.toml")
    assert low < child.effects.tapered_bore.friction < high
    assert json.loads((tmp_path / "found" / "verdict.json").read_text())["lineage"]["effect_tapered_bore_sha256"]
    code, told = told_by(apesim, "gap", "explain", folder, "--out", "without")
    assert code == 0
    assert (told["verdict"], told["effects"]) == ("REFUSED", [])
