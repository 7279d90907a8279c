"""What checksums do not see, digests do; and any program can compute them again."""

import hashlib
import shutil

import h5py
import numpy as np
import pytest

from apesim.archive import ArchiveError, read, read_about, read_digest, write
from apesim.archive.inspection import info, verify
from tests.archive_samples import VERSION_1, same, sample

ATTRIBUTES = (
    "axes coordinate coordinates dimensions finite flag_meanings flag_values long_name meanings reference units"
)


@pytest.fixture
def path(tmp_path):
    return write(sample(runs=range(12), angles=60), tmp_path / "a.h5")


def by_the_recipe(path):
    """Root digest and list of digests, computed by the words of `apesim.archive.digests` alone."""
    lines = []
    with h5py.File(path) as file:
        names = [*file, "about/machine", "about/provenance"]
        for name in sorted(f"/{name}" for name in names if name != "about"):
            dataset = file[name]
            kind = {"f": "f8", "i": f"i{dataset.dtype.itemsize}", "S": f"S{dataset.dtype.itemsize}"}[dataset.dtype.kind]
            header = [name, kind, " ".join(str(n) for n in dataset.shape)]
            for key in ATTRIBUTES.split():
                if key in dataset.attrs:
                    value = dataset.attrs[key]
                    value = value.decode() if isinstance(value, bytes) else " ".join(map(str, np.atleast_1d(value)))
                    header.append(f"{key}={value}")
            content = "\n".join([*header, ""]).encode() + dataset[...].tobytes()
            lines.append(f"{hashlib.sha256(content).hexdigest()}  {name}\n")
        about = ""
        for key in ("Conventions", "format", "format_version", "history", "source", "title"):
            if key in file.attrs:
                value = file.attrs[key]
                about += f"{key}={value.decode() if isinstance(value, bytes) else value}\n"
        listed = "".join(lines)
        return hashlib.sha256((about + listed).encode()).hexdigest(), listed, file["about/digests"][0].decode()


def test_any_program_can_compute_the_digests_again(path):
    root, listed, stored = by_the_recipe(path)
    assert listed == stored
    assert root == read_digest(path) == info(path)["content_sha256"]


def test_the_digest_is_that_of_the_content(path, tmp_path):
    assert read_digest(write(sample(range(12), angles=60), tmp_path / "b.h5")) == read_digest(path)
    assert read_digest(write(sample(range(11), angles=60), tmp_path / "b.h5")) != read_digest(path)
    assert read_digest(write(sample(range(12), angles=60, note="x"), tmp_path / "b.h5")) != read_digest(path)


def test_a_word_that_the_checksum_does_not_tell_from_another_is_seen(path):
    """Fletcher's checksum counts modulo 65535: to it 0000 is FFFF, and zero is NaN."""
    content = path.read_bytes()
    with h5py.File(path) as file:
        places = {name: file[name].id.get_chunk_info(0) for name in ("torque", "run", "cycles", "cylinder_pressure")}
    flips = [
        at
        for chunk in places.values()
        for at in range(chunk.byte_offset, chunk.byte_offset + chunk.size - 4, 2)
        if content[at : at + 2] == b"\0\0"
    ]
    assert len(flips) > 60
    for at in flips[:60]:
        damaged = bytearray(content)
        damaged[at : at + 2] = b"\xff\xff"
        path.write_bytes(damaged)
        with h5py.File(path) as file:
            for name in places:
                file[name][...]  # the checksums let it pass
        with pytest.raises(ArchiveError, match="SHA-256"):
            read(path)
        assert len(verify(path)) == 1


def exchange(file):
    for old, new in (("torque", "x"), ("speed", "torque"), ("x", "speed")):
        file.move(old, new)


def exchange_values(file):
    torque, speed = file["torque"][...], file["speed"][...]
    file["torque"][...], file["speed"][...] = speed, torque


def describe(name, text):
    def change(file):
        file["torque"].attrs.create(name, np.bytes_(text), dtype=h5py.string_dtype("utf-8", len(text)))

    return change


CHANGES = {
    "a value with its checksum": (lambda f: f["torque"].__setitem__(2, 99.0), "torque"),
    "a sample of a trace": (lambda f: f["cylinder_pressure"].__setitem__((3, 7), 1e5), "cylinder_pressure"),
    "an axis": (lambda f: f["crank_angle"].__setitem__(1, 13.0), "crank_angle"),
    "a code": (lambda f: f["intake"].__setitem__(0, 1), "intake"),
    "a text": (lambda f: f["warning"].__setitem__(0, b"none"), "warning"),
    "datasets exchanged": (exchange, "speed|torque"),
    "values exchanged": (exchange_values, "speed|torque"),
    "unit": (describe("units", b"kN m"), "torque"),
    "description": (describe("long_name", b"indicated torque"), "torque"),
    "meanings": (lambda f: f["intake"].attrs.create("meanings", np.bytes_("0 cam, 1 epv"), dtype="S12"), "intake"),
    "what must be finite": (lambda f: f["speed"].attrs.__delitem__("finite"), "speed"),
    "a variable removed": (lambda f: f.__delitem__("torque"), "torque: is missing"),
    "a variable added": (lambda f: f.copy("torque", "power"), "power: has no digest"),
    "the machine": (
        lambda f: f["about/machine"].write_direct(
            np.array([f["about/machine"][0].replace(b"90 mm", b"91 mm")], f["about/machine"].dtype)
        ),
        "about/",
    ),
    "the provenance": (
        lambda f: f["about/provenance"].write_direct(
            np.array([f["about/provenance"][0].replace(b"2024", b"2025")], f["about/provenance"].dtype)
        ),
        "about/provenance",
    ),
    "a listed digest": (
        lambda f: f["about/digests"].write_direct(
            np.array([f["about/digests"][0].replace(b"/speed", b"/specs")], f["about/digests"].dtype)
        ),
        "about/digests",
    ),
    "no digests": (lambda f: f["about"].__delitem__("digests"), "about/digests"),
    "the root digest": (lambda f: f.attrs.create("content_sha256", np.bytes_("0" * 64), dtype="S64"), "about/digests"),
    "the kind": (lambda f: f.attrs.create("kind", np.bytes_("valve map"), dtype="S9"), "about/provenance"),
}


@pytest.mark.parametrize("case", CHANGES)
def test_what_was_changed_by_another_program_is_named(path, case):
    change, name = CHANGES[case]
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        change(file)
    with pytest.raises(ArchiveError, match=rf"a\.h5: .*({name})"):
        read(path)
    assert verify(path)


def test_a_kind_is_an_attribute_of_the_root_outside_its_digest(tmp_path):
    path = write(sample(kind="engine sweep"), tmp_path / "a.h5")
    with h5py.File(path) as file:
        assert file.attrs["kind"] == b"engine sweep"
    assert verify(path) == [] and by_the_recipe(path)[0] == read_digest(path)


def test_an_archive_of_version_1_is_read_and_says_that_it_has_no_digests(tmp_path):
    assert same(read(VERSION_1), sample())
    assert read_about(VERSION_1)[1]["format_version"] == "1"
    assert verify(VERSION_1) == [] and read_digest(VERSION_1) is None
    assert info(VERSION_1)["content_sha256"] is None
    path = tmp_path / "old.h5"
    shutil.copy(VERSION_1, path)
    with h5py.File(path, "r+") as file:
        file.attrs.modify("format_version", 2)
    with pytest.raises(ArchiveError, match="about/digests"):
        read(path)
