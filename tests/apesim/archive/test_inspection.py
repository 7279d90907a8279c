import csv
import json
import shutil
import signal
import subprocess
import sys
import tomllib

import h5py
import numpy as np
import pytest

from apesim.archive import ArchiveError, Variable, write
from apesim.archive.errors import NoArchiveError
from apesim.archive.inspection import export, info, verify
from tests.archive_samples import MACHINE, VERSION_1, VERSION_2, sample
from tests.processes import ENVIRONMENT


@pytest.fixture
def path(tmp_path):
    return write(sample([0, 2, 3, 7]), tmp_path / "a.h5")


def test_info_is_plain_json(path):
    write(sample([0, 2, 3, 7], runs_planned="10"), path)
    about = json.loads(json.dumps(info(path)))
    assert about["format"] == "apesim archive" and about["bytes"] == path.stat().st_size
    assert (about["runs"], about["first_run"], about["last_run"]) == (4, 0, 7)
    assert about["runs_planned"] == 10
    assert about["missing_runs"] == [[1, 1], [4, 6], [8, 9]]
    assert about["axes"][1] == {
        "name": "crank_angle",
        "length": 5,
        "unit": "deg",
        "first": 0.0,
        "last": 720.0,
    }
    assert {
        "name": "intake",
        "dims": ["run"],
        "shape": [4],
        "dtype": "int8",
        "unit": "1",
        "description": "intake",
        "meanings": "0 epv, 1 cam",
    } in about["variables"]
    assert about["machine"] == MACHINE and about["created"] == "2024-01-01T00:00:00+00:00"
    assert about["versions"].keys() >= {"python", "numpy", "h5py"}
    assert info(write(sample(()), path))["axes"][0]["first"] is None


def test_sound_archives_have_no_fault(path):
    assert verify(path) == []


@pytest.mark.parametrize(
    ("runs", "told", "missing"),
    [
        ([0, 2, 3, 7], {}, "1, 4-6, 8-9"),
        ([0, 2, 4, 6], {"shard": "1/1"}, "1, 3, 5, 7-9"),
        ([0, 2, 4, 6], {"shard": "1/2"}, "8"),
        ([0, 2, 4, 6, 8], {"shard": "1/2"}, ""),
        ([1, 3, 7, 9], {"shard": "2/2"}, "5"),
        ([0, 1, 3, 4, 6, 7, 9], {"shard": "1/3; 2/3"}, ""),
        ([0, 1, 3, 6, 7, 9], {"shard": "1/3; 2/3"}, "4"),
        ([0, 2, 4, 6, 8], {"command": "apesim engine sweep --shard 1/2 --out a.h5"}, ""),
        ([0, 3, 6], {"command": "apesim engine sweep --shard=1/3; apesim engine sweep --shard=2/3"}, "1, 4, 7-9"),
        ([0, 2], {"shard": "0/0"}, "1, 3-9"),
        ([], {"shard": "1/2"}, "0-8"),
    ],
)
def test_an_archive_that_planned_more_than_it_holds_is_at_fault(path, runs, told, missing):
    write(sample(runs, runs_planned="10", **told), path)
    remedy = "go on with --resume, or compute it again"
    assert verify(path) == ([f"{path}: runs {missing} of 10 planned are missing; {remedy}"] if missing else [])


def test_a_huge_plan_is_no_burden(path):
    write(sample([0, 2], runs_planned="9" * 18, shard="1/2"), path)
    assert len(verify(path)) == 1


def test_all_faults_are_listed(path):
    with h5py.File(path, "r+") as file:
        file["run"][...] = [0, 2, 2, 3]
        del file["torque"].attrs["units"]
        file["intake"][0] = 5
        file["speed"][1] = np.nan
    faults = verify(path)
    assert len(faults) == 4
    for name, text in (("run", "increasing"), ("torque", "units"), ("intake", "code 5"), ("speed", "finite")):
        assert sum(f"{path}: {name}" in fault and text in fault for fault in faults) == 1, (name, faults)


def test_missing_checksums_and_scales_are_faults(path):
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        copied(file, "speed", fletcher32=False)
        file["torque"].dims[0].detach_scale(file["run"])
    torque, speed = verify(path)
    assert "speed: carries no checksums" in speed and "torque: axis run is not attached as dimension 0" in torque


def test_wrong_scales_are_faults(path):
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        file["cylinder_pressure"].dims[0].detach_scale(file["run"])
        file["cylinder_pressure"].dims[0].attach_scale(file["crank_angle"])
    [fault] = verify(path)
    assert "cylinder_pressure: axis run is not attached as dimension 0" in fault


def test_damaged_heap_of_axis_lists_does_not_hang(path):
    content = bytearray(path.read_bytes())
    place = content.index(b"GCOL")
    content[place + 100 : place + 400] = bytes(300)
    path.write_bytes(content)
    assert verify(path) == []


def test_axes_of_another_length_are_faults(path):
    shutil.copy(VERSION_1, path)
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        copied(file, "speed", shape=(4,), data=np.ones(4), fletcher32=True)
        file["speed"].dims[0].attach_scale(file["run"])
    [fault] = verify(path)
    assert "speed: 4 values along 'run' of 3" in fault


def copied(file, name, **options):
    attributes = {}
    for key in {"units", "long_name", "axes", "dimensions"} & file[name].attrs.keys():
        attribute = file[name].attrs.get_id(key)
        attributes[key] = np.empty((), attribute.dtype)
        attribute.read(attributes[key])
    values = file[name][...]
    del file[name]
    dataset = file.create_dataset(name, chunks=(3,), **{"data": values} | options)
    for key, value in attributes.items():
        dataset.attrs.create(key, value, dtype=value.dtype)


def test_machine_that_is_no_toml_is_a_fault(tmp_path):
    archive = sample()
    object.__setattr__(archive, "machine", "not toml")
    [fault] = verify(write(archive, tmp_path / "a.h5"))
    assert "about/machine: is no TOML" in fault


def test_what_is_no_archive_is_no_damaged_one(tmp_path):
    with pytest.raises(NoArchiveError, match="no such file"):
        verify(tmp_path / "none.h5")
    for number, form in enumerate(
        ({}, {"title": "x"}, {"format": "other"}, {"format": np.bytes_("other")}, {"format": 3})
    ):
        with h5py.File(tmp_path / f"{number}.h5", "w") as file:
            file["speed"] = np.arange(3.0)
            file.attrs.update(form)
        with pytest.raises(NoArchiveError, match="is not an apesim archive"):
            verify(tmp_path / f"{number}.h5")


@pytest.mark.parametrize("sample_of", [VERSION_1, VERSION_2, None])
@pytest.mark.parametrize("place", ["/", "about", "run", "about/machine"])
def test_an_attribute_that_no_digest_covers_is_a_fault(path, sample_of, place):
    if sample_of:
        shutil.copy(sample_of, path)
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        file[place].attrs["rig"] = "another"
    [fault] = verify(path)
    assert "attribute rig" in fault and (place == "/" or f"{place}:" in fault)


def test_a_dataset_or_group_that_no_digest_covers_is_a_fault(path):
    for name in ("more", "about/more"):
        shutil.copy(VERSION_1, path)
        with h5py.File(path, "r+", libver=("v110", "v110")) as file:
            file.create_group(name)
        [fault] = verify(path)
        assert f"{name}: " in fault


def table(path):
    with open(path, newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return header, rows


def test_export_reads_back_to_the_same_bits(tmp_path):
    archive = sample([0, 7, 12345])
    archive.variables["torque"].values[:] = [5e-324, -0.0, np.inf]
    path = write(archive, tmp_path / "a.h5")
    files = export(path, tmp_path / "out")
    assert {str(f.relative_to(tmp_path / "out")) for f in files} == {
        "machine.toml",
        "provenance.json",
        "variables.csv",
        "runs.csv",
        "traces/run_0000.csv",
        "traces/run_0007.csv",
        "traces/run_12345.csv",
    }
    assert {f for f in (tmp_path / "out").rglob("*") if f.is_file()} == set(files)

    header, rows = table(tmp_path / "out/runs.csv")
    assert header == ["run [1]", "speed [rpm]", "torque [N m]", "cycles [1]", "intake", "warning [1]"]
    for column, name in zip(zip(*rows, strict=True), (h.split(" [")[0] for h in header), strict=True):
        if name == "intake":  # in words, which variables.csv says
            assert [["epv", "cam"].index(word) for word in column] == archive.variables[name].values.tolist()
            continue
        values = archive.variables[name].values
        assert np.array(column).astype(values.dtype).tobytes() == values.tobytes(), name

    header, rows = table(tmp_path / "out/traces/run_0007.csv")
    assert header == ["crank_angle [deg]", "cylinder_pressure [Pa abs]"]
    columns = np.array(rows, dtype=float).T.copy()
    assert columns[0].tobytes() == archive.variables["crank_angle"].values.tobytes()
    assert columns[1].tobytes() == archive.variables["cylinder_pressure"].values[1].tobytes()

    assert (tmp_path / "out/machine.toml").read_bytes().decode() == MACHINE
    assert tomllib.loads(MACHINE)["engine"]["bore"] == "90 mm"
    assert json.loads((tmp_path / "out/provenance.json").read_text())["plan_hash"] == "p"
    assert ["intake", "1", "int8", "run", "0 epv, 1 cam", "intake"] in table(tmp_path / "out/variables.csv")[1]


def test_export_of_several_axes(tmp_path):
    archive = sample([3])
    lift = np.arange(10.0).reshape(1, 2, 5)
    archive.variables["valve"] = Variable(("valve",), np.array(["in", "out"]), "1", "valve")
    archive.variables["lift"] = Variable(("run", "valve", "crank_angle"), lift, "m", "lift")
    export(write(archive, tmp_path / "a.h5"), tmp_path / "out")
    header, rows = table(tmp_path / "out/traces/run_0003_valve_crank_angle.csv")
    assert header == ["valve [1]", "crank_angle [deg]", "lift [m]"]
    assert rows[5] == ["out", "0.0", "5.0"] and len(rows) == 10
    assert len(table(tmp_path / "out/traces/run_0003_crank_angle.csv")[1]) == 5


def test_export_overwrites_nothing(path, tmp_path):
    (tmp_path / "out").mkdir()
    export(path, tmp_path / "out")
    with pytest.raises(ArchiveError, match="not empty"):
        export(path, tmp_path / "out")
    shutil.rmtree(tmp_path / "out")
    (tmp_path / "out").write_text("")
    with pytest.raises(ArchiveError, match="cannot be written"):
        export(path, tmp_path / "out")


@pytest.mark.skipif(not hasattr(signal, "SIGXFSZ"), reason="no limit of file sizes here")
@pytest.mark.parametrize("is_there", [False, True])
def test_an_export_that_fails_leaves_nothing(tmp_path, is_there):
    """The system refuses the largest file, after several others were written."""
    write(sample([0, 1], angles=2000), tmp_path / "a.h5")
    if is_there:
        (tmp_path / "out").mkdir()
    script = """
import resource
from apesim.archive import ArchiveError
from apesim.archive.inspection import export
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
try:
    export("a.h5", "out")
except ArchiveError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "run_0000.csv: could not be written (File too large)" in done.stdout
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["a.h5", "out"][: 1 + is_there]
    assert not is_there or not any((tmp_path / "out").iterdir())
