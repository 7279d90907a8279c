import errno
import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st

from apesim.archive import Archive, ArchiveError, Variable, command_line, read, read_about, sha256, write
from apesim.archive.inspection import verify
from tests.archive_samples import same, sample
from tests.processes import ENVIRONMENT

TEXT = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=12)
# Printable by its category, not by a filter: older versions of hypothesis draw mostly characters that it would refuse.
PRINTABLE = st.characters(exclude_categories=["C", "Z"])
LINE = st.text(PRINTABLE | st.just(" "), max_size=12)
UNIT = st.builds("{}{}{}".format, LINE, PRINTABLE, LINE)


@st.composite
def archives(draw):
    lengths = {"run": draw(st.integers(0, 5)), "crank_angle": draw(st.integers(0, 4)), "place": 2}
    numbers = draw(st.lists(st.integers(0, 2**63 - 1), min_size=lengths["run"], max_size=lengths["run"], unique=True))
    variables = {
        "run": Variable(("run",), np.array(sorted(numbers), dtype=np.int64), "1", "run number"),
        "crank_angle": Variable(("crank_angle",), np.linspace(-1.0, 0.3, lengths["crank_angle"]), "deg", "angle"),
        "place": Variable(("place",), np.array(["in", "außen"]), "1", "place"),
    }
    elements = {
        "f": st.floats(),
        "i": st.integers(-(2**63), 2**63 - 1),
        "b": st.integers(-128, 127),
        "t": TEXT,
    }
    kinds = {"f": np.float64, "i": np.int64, "b": np.int8, "t": np.str_}
    for i, kind in enumerate(draw(st.lists(st.sampled_from("fibt"), max_size=6))):
        dims = draw(st.sampled_from([("run",), ("run", "crank_angle"), ("run", "place", "crank_angle")]))
        shape = tuple(lengths[axis] for axis in dims)
        size = int(np.prod(shape))
        values = draw(st.lists(elements[kind], min_size=size, max_size=size))
        unit = draw(UNIT)
        variables[f"v{i}"] = Variable(dims, np.array(values, dtype=kinds[kind]).reshape(shape), unit, draw(LINE))
    return Archive(draw(TEXT), draw(st.dictionaries(LINE.map("note {}".format), TEXT, max_size=3)), variables)


@settings(max_examples=80)
@given(archives())
def test_round_trip(tmp_path_factory, archive):
    path = write(archive, tmp_path_factory.mktemp("round") / "a.h5")
    back = read(path)
    assert same(archive, back)
    assert archive.provenance.items() <= back.provenance.items()


def test_provenance_says_where_it_comes_from_but_not_who(tmp_path):
    machine, provenance = read_about(write(replace(sample(), provenance={}), tmp_path / "a.h5"))
    assert machine == sample().machine
    assert provenance["format"] == "apesim archive" and provenance["format_version"] == "3"
    assert provenance["machine_sha256"] == sha256(machine)
    assert provenance["created"].endswith("+00:00")
    at_work = {"numba", "llvmlite", "scipy"} & sys.modules.keys()
    versions = {"apesim", "python", "numpy", "h5py", "hdf5"} | at_work
    assert versions | {"platform", "processor"} <= provenance.keys()
    everything = " ".join(provenance.values())
    assert str(Path.home()) not in everything and os.uname().nodename not in everything


def test_write_alone_says_what_the_format_and_the_machine_are(tmp_path):
    wrong = {"format": "x", "format_version": "9", "machine_sha256": "0", "numpy": "0.1"}
    _, provenance = read_about(write(sample(**wrong), tmp_path / "a.h5"))
    assert (provenance["format"], provenance["format_version"]) == ("apesim archive", "3")
    assert provenance["machine_sha256"] == sha256(sample().machine) and provenance["numpy"] == "0.1"


def test_command_line_names_no_folders():
    assert (
        command_line(
            [
                "/home/eve/bin/apesim",
                "run",
                "--out=/home/eve/F.h5",
                "~/m.toml",
                "C:\\Users\\eve\\x.h5",
                "1:2:3 rpm",
            ]
        )
        == "apesim run --out=F.h5 m.toml x.h5 '1:2:3 rpm'"
    )


def test_same_content_gives_the_same_bytes(tmp_path):
    first = write(sample(), tmp_path / "a.h5").read_bytes()
    time.sleep(1.1)  # HDF5 would stamp objects in whole seconds
    assert write(sample(), tmp_path / "b.h5").read_bytes() == first
    reordered = dict(reversed(sample().provenance.items()))
    assert write(replace(sample(), provenance=reordered), tmp_path / "c.h5").read_bytes() == first
    assert write(sample(created="later"), tmp_path / "d.h5").read_bytes() != first


def test_file_is_checksummed_chunked_and_old_enough_for_other_readers(tmp_path):
    path = write(sample(angles=40_000), tmp_path / "a.h5")
    datasets = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: datasets.update({name: item}) if hasattr(item, "chunks") else None)
        assert set(datasets) == {*sample().variables, "about/machine", "about/provenance", "about/digests"}
        for dataset in datasets.values():
            assert dataset.fletcher32 and dataset.chunks and not dataset.compression
        pressure = datasets["cylinder_pressure"]
        assert pressure.chunks[1:] == (40_000,) and pressure.chunks[0] == 3
        assert datasets["warning"].dtype.kind == "S" and not h5py.check_vlen_dtype(datasets["warning"].dtype)
        assert [d[0].name for d in pressure.dims] == ["/run", "/crank_angle"]
    assert path.read_bytes()[8] <= 3  # superblock of HDF5 1.10


def test_chunks_hold_whole_runs_of_about_a_mebibyte(tmp_path):
    runs = np.arange(400)
    with h5py.File(write(sample(runs, angles=721), tmp_path / "a.h5")) as file:
        assert file["cylinder_pressure"].chunks == (2**20 // (721 * 8), 721)


def test_xarray_sees_axes_units_and_text(tmp_path):
    path = write(sample(), tmp_path / "a.h5")
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        assert dict(data.sizes) == {"run": 3, "crank_angle": 5}
        assert set(data.coords) == {"run", "crank_angle"}
        assert data.cylinder_pressure.dims == ("run", "crank_angle")
        assert (data.cylinder_pressure.attrs["units"], data.cylinder_pressure.attrs["reference"]) == ("Pa", "absolute")
        assert data.crank_angle.attrs["units"] == "degree"
        assert data.cylinder_pressure.attrs["long_name"] == "pressure in the cylinder"
        assert data.intake.attrs["flag_meanings"] == "epv cam" and data.intake.dtype == np.int8
        assert data.intake.attrs["flag_values"].tolist() == [0, 1] and data.intake.attrs["flag_values"].dtype == np.int8
        assert data.warning.values.tolist() == sample().variables["warning"].values.tolist()
        np.testing.assert_array_equal(data.torque, sample().variables["torque"].values)


def test_an_empty_part_can_be_written(tmp_path):
    back = read(write(sample(runs=()), tmp_path / "a.h5"))
    assert same(back, sample(runs=())) and len(back.runs) == 0


def test_no_bit_flip_is_silent(tmp_path):
    good, path = sample(runs=range(12), angles=60), tmp_path / "a.h5"
    content = write(good, path).read_bytes()
    stored = read(path)
    random = np.random.default_rng(20240607)
    detected = 0
    for position in random.integers(0, 8 * len(content), 200):
        flipped = bytearray(content)
        flipped[position // 8] ^= 1 << (position % 8)
        path.write_bytes(flipped)
        try:
            back = read(path)
        except ArchiveError as error:
            assert "\n" not in str(error) and str(path) in str(error)
            assert verify(path)
            detected += 1
            continue
        assert same(back, stored) and back.provenance == stored.provenance, f"bit {position} is silent"
    assert detected > 100


@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_failed_writing_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, call):
    path = write(sample(), tmp_path / "a.h5")
    before = path.read_bytes()

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, call, full)
    with pytest.raises(ArchiveError, match="No space left"):
        write(sample(runs=range(9)), path)
    assert os.listdir(tmp_path) == ["a.h5"] and path.read_bytes() == before


def test_interrupted_writing_leaves_no_temporary_file(tmp_path, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write(sample(), tmp_path / "a.h5")
    assert os.listdir(tmp_path) == []


def test_real_size_limit_of_the_system_does_not_crash(tmp_path):
    script = """
import resource
from tests.archive_samples import sample
from apesim.archive import ArchiveError, read, write
resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))
try:
    write(sample(range(200), angles=721), "a.h5")
except ArchiveError as error:
    print(error)
write(sample(), "b.h5")
print(len(read("b.h5").runs))
"""
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "a.h5: could not be written (File too large)" in done.stdout and done.stdout.endswith("3\n")
    assert os.listdir(tmp_path) == ["b.h5"]


def test_file_and_folder_reach_the_disk_before_and_after_the_rename(tmp_path, monkeypatch):
    calls = []
    for name in ("fsync", "replace"):
        true = getattr(os, name)
        monkeypatch.setattr(os, name, lambda *args, name=name, true=true: (calls.append(name), true(*args)))
    write(sample(), tmp_path / "a.h5")
    assert calls == ["fsync", "replace", "fsync"]


def test_missing_folder_is_one_line(tmp_path):
    with pytest.raises(ArchiveError, match=r"could not be written .No such file"):
        write(sample(), tmp_path / "none" / "a.h5")


def test_an_archive_that_xarray_has_open_is_read_and_stays_open(tmp_path):
    path = write(sample(), tmp_path / "a.h5")
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        assert verify(path) == []
        assert data["speed"].values.tolist() == read(path).variables["speed"].values.tolist()


@pytest.mark.parametrize("locking", [None, True, "best-effort"])
def test_an_archive_that_is_open_with_other_locking_is_read_and_stays_open(tmp_path, locking):
    path = write(sample(), tmp_path / "a.h5")
    with h5py.File(path, locking=locking) as file:
        assert file["speed"][...].tolist() == read(path).variables["speed"].values.tolist()


def test_what_was_once_called_uncorrected_is_read_as_fixed(tmp_path):
    old = sample()
    old.variables["uncorrected_brake_torque_Nm"] = old.variables.pop("torque")
    again = read(write(old, tmp_path / "timing.h5"))
    assert "fixed_brake_torque_Nm" in again.variables and "uncorrected_brake_torque_Nm" not in again.variables
    assert verify(write(again, tmp_path / "again.h5")) == []
