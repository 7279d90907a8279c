"""Archives as programs that follow the CF conventions see them."""

import re
import subprocess
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray
from pint import UnitRegistry

import apesim
import apesim.engine
import apesim.studies
from apesim.archive import Variable, read, read_about, read_digest, surroundings, write
from apesim.archive.conventions import UNITS, cf_unit, our_unit
from apesim.archive.grid import read_grid
from apesim.archive.inspection import verify
from tests.archive_samples import VERSION_2, VERSION_2_SWEEP, same, sample

FLAG_WORD = re.compile(r"[A-Za-z0-9_.+@-]+")


def own_units():
    """Units that the sources give to variables of archives, by our names."""
    folders = [folder for layer in (apesim, apesim.engine, apesim.studies) for folder in layer.__path__]
    text = "".join(path.read_text() for folder in folders for path in sorted(Path(folder).rglob("*.py")))
    return sorted(set(re.findall(r'"((?:deg|Pa|r/min|kg|N m|L/min|m|m3|s|K|J|W|Hz|1)(?: abs|/[a-zA-Z]+)?)"', text)))


def test_units_of_archives_are_those_of_pint():
    registry, checked = UnitRegistry(), own_units()
    assert {"Pa abs", "deg", "r/min", "kg/kWh", "N m", "L/min", "m/s", "kg/s"} <= set(checked)
    for unit in checked:
        registry.parse_units(cf_unit(unit)[0])


@pytest.mark.parametrize(
    ("unit", "others", "in_si"),
    [("deg", "degree", np.pi / 180.0), ("kg/kWh", "kg kW^-1 h^-1", 1.0 / 3.6e6), ("m3", "m^3", 1.0)],
)
def test_units_mean_the_same_by_the_name_of_others(unit, others, in_si):
    assert cf_unit(unit) == (others, "")
    assert UnitRegistry().Quantity(1.0, others).to_base_units().magnitude == pytest.approx(in_si, rel=1e-12)
    assert our_unit(others, "") == unit


def test_revolutions_a_minute_are_counted():
    assert UnitRegistry().Quantity(60.0, UNITS["r/min"]).to("1/s").magnitude == pytest.approx(1.0)


def test_a_pressure_says_what_it_is_measured_from():
    assert cf_unit("Pa abs") == ("Pa", "absolute") and our_unit("Pa", "absolute") == "Pa abs"
    assert cf_unit("kPa gauge") == ("kPa", "gauge") and our_unit("kPa", "gauge") == "kPa gauge"
    assert cf_unit("Pa") == ("Pa", "") and our_unit("Pa", "") == "Pa"


def located():
    """Runs at speeds, with codes whose meanings are no single words."""
    archive = sample()
    speed, intake = archive.variables["speed"], archive.variables["intake"]
    archive.variables["speed"] = replace(speed, unit="r/min", coordinate=True)
    archive.variables["intake"] = replace(intake, meanings="0 of the grid, 1 the machine's own")
    return archive


def test_codes_have_flag_values_and_words(tmp_path):
    with h5py.File(write(located(), tmp_path / "a.h5")) as file:
        assert file["intake"].attrs["flag_values"].tolist() == [0, 1]
        assert file["intake"].attrs["flag_values"].dtype == file["intake"].dtype
        words = file["intake"].attrs["flag_meanings"].decode().split()
    assert words == ["of_the_grid", "the_machine_s_own"] and all(map(FLAG_WORD.fullmatch, words))
    assert read(tmp_path / "a.h5").variables["intake"].meanings == "0 of the grid, 1 the machine's own"


def test_results_name_their_coordinates(tmp_path):
    path = write(located(), tmp_path / "a.h5")
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        assert set(data.coords) == {"run", "crank_angle", "speed"}
        assert data.torque.coords["speed"].values.tolist() == located().variables["speed"].values.tolist()
        assert "speed" in data.cylinder_pressure.coords and "speed" not in data.crank_angle.coords
        assert data.speed.attrs["units"] == "min^-1"
    assert same(read(path), located()) and read(path).variables["speed"].coordinate


def test_no_variable_is_taken_for_a_domain(tmp_path):
    """CF takes what has an attribute ``dimensions`` for a domain variable, which holds no data."""
    with h5py.File(write(sample(), tmp_path / "a.h5")) as file:
        assert not [name for name in file if "dimensions" in file[name].attrs]


def test_the_file_says_its_conventions_and_where_it_comes_from(tmp_path):
    given = {"command": "apesim engine sweep", "title": "Engine sweep", "apesim": "9.9", "commit": "abc"}
    with h5py.File(write(sample(**given), tmp_path / "a.h5")) as file:
        about = {name: file.attrs[name].decode() for name in ("Conventions", "title", "source", "history")}
    assert about == {
        "Conventions": "CF-1.11",
        "title": "Engine sweep",
        "source": "apesim 9.9, commit abc",
        "history": "2024-01-01T00:00:00+00:00 apesim engine sweep",
    }


def test_a_changed_global_attribute_is_seen(tmp_path):
    path = write(sample(), tmp_path / "a.h5")
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        file.attrs.create("source", np.bytes_("apesim 0.0"), dtype="S10")
    assert len(verify(path)) == 1


def test_grids_carry_the_conventions(tmp_path):
    data = read_grid(VERSION_2_SWEEP)
    assert data.attrs["Conventions"] == "CF-1.11"
    assert data["speed_rpm"].attrs["units"] == "min^-1"
    assert "flag_values" not in data["actuation"].attrs and "epv corrected" in data["actuation"].values
    assert data["cylinder_pressure"].attrs["reference"] == "absolute"


def test_archives_of_version_2_are_read_with_units_by_our_names(tmp_path):
    assert same(read(VERSION_2), sample()) and verify(VERSION_2) == []
    assert read_about(VERSION_2)[1]["format_version"] == "2" and len(read_digest(VERSION_2)) == 64
    old = read(VERSION_2_SWEEP)
    units = {
        name: old.variables[name].unit for name in ("crank_angle", "cylinder_pressure", "speed_rpm", "cylinder_volume")
    }
    assert units == {
        "crank_angle": "deg",
        "cylinder_pressure": "Pa abs",
        "speed_rpm": "r/min",
        "cylinder_volume": "m3",
    }
    again = read(write(old, tmp_path / "again.h5"))
    assert same(again, old) and again.provenance["format_version"] == "3"
    located = [name for name, variable in again.variables.items() if variable.coordinate]
    assert located == ["actuation", "speed_rpm"]


def test_a_coordinate_without_results_is_kept(tmp_path):
    archive = sample()
    archive.variables["bore"] = Variable(("run",), np.ones(3), "m", "bore of the machine", coordinate=True)
    assert read(write(archive, tmp_path / "a.h5")).variables["bore"].coordinate


@pytest.fixture
def asked_afresh():
    surroundings.commit.cache_clear()
    yield
    surroundings.commit.cache_clear()


def test_a_checkout_names_its_commit_and_whether_files_were_changed(tmp_path, monkeypatch, asked_afresh):
    def git(*arguments):
        command = ["git", "-C", tmp_path, "-c", "user.name=x", "-c", "user.email=x@x", *arguments]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()

    source = tmp_path / "apesim" / "__init__.py"
    source.parent.mkdir()
    source.write_text("")
    monkeypatch.setattr(apesim, "__file__", str(source))
    assert surroundings.commit() == ""
    surroundings.commit.cache_clear()
    git("init", "-q")
    git("add", ".")
    git("commit", "-q", "-m", "x")
    head = git("rev-parse", "HEAD")
    assert surroundings.commit() == head
    surroundings.commit.cache_clear()
    source.write_text("changed = True\n")
    assert surroundings.commit() == f"{head}-dirty"


def test_the_processor_has_a_name():
    assert surroundings.processor().strip()
