"""Pages as files: where they are written, what is refused, and measured points over the curves."""

import json
import re

import numpy as np
import pytest

import apesim as public
from apesim.archive import ArchiveError
from apesim.quantities import InputError
from apesim.studies.report.measured_points import add_measured, find_means
from apesim.studies.report.page import write_content
from apesim.studies.report.writing import prepare_page
from tests.studies.gap.test_dyno_curve import run_at, write_folder
from tests.studies.report.conftest import found, page_of

MEANS = {"torque": 20.0, "air_flow": 0.05}


@pytest.fixture(scope="module")
def dyno(tmp_path_factory):
    """Folder of a dynamometer's curve: two speeds, one of them twice."""
    runs = tuple(
        run_at(rpm, means=MEANS | {"torque": torque}) for rpm, torque in ((700, 33.0), (700, 35.0), (1200, 14.0))
    )
    return write_folder(
        tmp_path_factory.mktemp("dyno"), public.studies.measured.Measured("", {}, runs, "engine", 101325.0)
    )


def test_a_command_writes_the_page_beside_the_archive_the_same_each_time(apesim, tmp_path):
    found("map").write(tmp_path / "map.h5")
    code, out, _ = apesim("report", "map.h5", "--json")
    first = (tmp_path / "map.html").read_bytes()
    assert code == 0 and json.loads(out) == {"file": "map.html", "bytes": len(first)}
    assert apesim("report", "map.h5")[0] == 2 and (tmp_path / "map.html").read_bytes() == first
    assert apesim("report", "map.h5", "--out", "other.html")[0] == 0
    assert (tmp_path / "other.html").read_bytes() == first
    assert apesim("report", "map.h5", "--set", "engine.bore=90 mm", "--overwrite")[0] == 3


def test_a_study_writes_its_page_too(apesim, tmp_path):
    place = ("--pressure", "1 MPa gauge", "--temperature", "287 K")
    code, out, _ = apesim("valve", "map", *place, "--no-figures", "--json", "--report", "page.html")
    assert code == 0 and json.loads(out)["report"] == "page.html"
    apesim("report", "valve_map.h5")
    assert (tmp_path / "page.html").read_bytes() == (tmp_path / "valve_map.html").read_bytes()


def test_a_page_that_exists_is_refused_before_anything_is_computed(apesim, tmp_path):
    (tmp_path / "page.html").write_text("mine")
    code, _, err = apesim("engine", "transient", "--duration", "0.1 s", "--angle", "30 deg", "--report", "page.html")
    assert code == 2 and err.startswith("page.html: exists already") and (tmp_path / "page.html").read_text() == "mine"
    with pytest.raises(ArchiveError, match="is a folder"):
        prepare_page(tmp_path, overwrite=True)
    assert prepare_page(None, overwrite=False)("no.h5") == {}


def test_a_result_needs_a_page_to_be_named(tmp_path):
    with pytest.raises(InputError, match="a result has no file"):
        public.write_report(found("map"))
    path = public.write_report(found("map"), tmp_path / "map.html")
    assert path.read_text(encoding="utf-8") == page_of("map")


def test_a_page_names_what_the_machine_departs_in_and_what_it_assumes(tmp_path):
    machine = public.Machine().with_(valve_stroke="8 mm", effects_cylinder_wall_heat_factor=1.0)
    result = public.map_valve(machine, pressure="1 MPa gauge", temperature="287 K")
    text = public.write_report(result, tmp_path / "map.html").read_text(encoding="utf-8")
    assert "<td>valve.stroke</td><td>8 mm</td><td>9 mm</td>" in text
    assert "Heat from the walls" in text and "Adiabatic" not in text and "Adiabatic" in page_of("map")


def test_measured_means_are_drawn_over_the_speed(dyno):
    measured = public.read_measured(dyno)
    content = add_measured(write_content(found("sweep"), "engine sweep")[0], measured)
    figures = {
        figure.name: figure for section in content.sections for figure in section.figures if hasattr(figure, "name")
    }
    torque = figures["brake_torque_Nm"].lines[-1]
    assert torque.label == "measured, 1.1 MPa abs" and not torque.has_line
    assert torque.values[0].tolist() == [33.0, 35.0, 14.0] and torque.x[0] == pytest.approx([700.0, 700.0, 1200.0])
    assert np.all(np.diff(torque.x[0]) > 0.0)
    [power] = figures["brake_power_W"].lines[-1].values
    assert power[2] == pytest.approx(14.0 * 1200.0 * np.pi / 30.0 / 1000.0)
    assert len(figures["valve_open_deg"].lines) == 4


def test_measured_means_become_what_the_sweep_has():
    archive = found("sweep").archive
    v = {name: float(variable.values[0]) for name, variable in archive.variables.items() if variable.dims == ("run",)}
    air = (v["engine_air_kg_per_cycle"] + v["control_air_kg_per_cycle"]) * v["speed_rpm"] / 60.0
    numbers = find_means(run_at(v["speed_rpm"], means={"torque": v["brake_torque_Nm"], "air_flow": air}))
    for name, number in numbers.items():
        assert number == pytest.approx(v[name] * (1e-3 if name == "brake_power_W" else 1.0), rel=1e-9)
    assert find_means(run_at(600.0, means={"torque": -1.0})).keys() == {"brake_torque_Nm", "brake_power_W"}


@pytest.mark.parametrize(
    ("kind", "text"), [("map", "has nothing to be drawn over"), ("transient", "has nothing to be")]
)
def test_measured_means_over_no_speed_are_refused(dyno, kind, text, tmp_path):
    with pytest.raises(InputError, match=text):
        public.write_report(found(kind), tmp_path / "page.html", measured=dyno)
    assert not (tmp_path / "page.html").exists()


def test_a_page_names_no_address_that_it_would_load():
    text = page_of("sweep")
    assert not re.search(r"""(?:src|href)=["'](?!data:|#)""", text) and "@import" not in text and "url(" not in text
