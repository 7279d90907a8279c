import pickle
import subprocess
import sys

import h5py
import numpy as np
import pytest

from apesim.archive import ArchiveError, read, write
from apesim.archive.errors import NoArchiveError
from apesim.archive.inspection import verify
from tests.archive_samples import sample


@pytest.fixture
def path(tmp_path):
    return write(sample(), tmp_path / "a.h5")


def add(file, name="x", **options):
    options = {"shape": (3,), "dtype": "<f8"} | options
    return file.create_dataset(name, **options)


def virtual(file):
    layout = h5py.VirtualLayout(shape=(3,), dtype="<f8")
    layout[:] = h5py.VirtualSource("/etc/passwd", "speed", shape=(3,))
    file.create_virtual_dataset("x", layout)


def named_type(file):
    file["x"] = np.dtype("<f8")


def vlen(file):
    add(file, dtype=h5py.string_dtype())


def deep(file):
    add(file, "about/more/x", dtype=h5py.string_dtype())


TAMPERED = {
    "soft link": (lambda f: f.update({"x": h5py.SoftLink("/speed")}), "x is a soft link"),
    "dangling link": (lambda f: f.update({"x": h5py.SoftLink("/none")}), "x is a soft link"),
    "external link": (
        lambda f: f.update({"x": h5py.ExternalLink("/etc/passwd", "/")}),
        "x is an external link",
    ),
    "cycle": (lambda f: f.update({"about/x": f["/"]}), "about/x is a second link"),
    "hard link": (lambda f: f.update({"x": f["speed"]}), "second link to the same object"),
    "external storage": (lambda f: add(f, external=[("/etc/passwd", 0, 24)]), "x is stored in another file"),
    "virtual": (virtual, "x is a virtual dataset"),
    "filter": (lambda f: add(f, chunks=(3,), compression="lzf"), "x needs the filter 32000"),
    "scale offset": (lambda f: add(f, chunks=(3,), scaleoffset=2), "x needs the filter 6"),
    "vlen": (vlen, "x holds text of variable length"),
    "deep": (deep, "about/more/x holds text of variable length"),
    "vlen numbers": (lambda f: add(f, dtype=h5py.vlen_dtype("<f8")), "x holds the type variable length"),
    "reference": (lambda f: add(f, dtype=h5py.ref_dtype), "x holds the type reference"),
    "compound": (lambda f: add(f, dtype=[("a", "<f8")]), "x holds the type compound"),
    "float32": (lambda f: add(f, dtype="<f4"), "x holds the type float32"),
    "big endian": (lambda f: add(f, dtype=">f8"), "x holds the type >f8"),
    "scalar": (lambda f: add(f, shape=()), "x has no extent"),
    "null": (lambda f: f.update({"x": h5py.Empty("<f8")}), "x has no extent"),
    "named type": (named_type, "x is neither group nor dataset"),
    "huge": (
        lambda f: add(f, shape=(2**62,), chunks=(64,)),
        "x: the datasets are larger than 4294967296 bytes",
    ),
    "huge together": (
        lambda f: [add(f, f"x{i}", shape=(2**28,), chunks=(64,)) for i in range(3)],
        "larger than",
    ),
    "huge chunk": (
        lambda f: (
            add(f, maxshape=(None,), chunks=(2**29 - 1,), compression="gzip")
            and add(f, "y", maxshape=(None,), chunks=(2**29 - 1,))
        ),
        "larger than",
    ),
    "huge text": (lambda f: add(f, shape=(2**20,), dtype="S1000", chunks=(64,)), "larger than"),
    "many": (
        lambda f: [f.update({f"about/x{i}": h5py.SoftLink("/")}) for i in range(10_000)],
        "more than 10000",
    ),
    "newer": (lambda f: f.attrs.modify("format_version", 4), "format version 4.*newer apesim"),
    "older": (lambda f: f.attrs.modify("format_version", 1), "its format_version is not that of the file"),
    "other format": (lambda f: f.attrs.__delitem__("format"), "is not an apesim archive"),
    "group": (lambda f: f.create_group("x"), "x: "),
    "never written": (lambda f: replaced(f, "speed", chunks=(3,)), "speed: 0 of 1 chunks"),
    "foreign units": (lambda f: f["speed"].attrs.__setitem__("units", "m"), "speed: attribute units"),
    "foreign codes": (
        lambda f: f["intake"].attrs.create("flag_values", [0, 1], dtype="<i8"),
        "intake: attribute flag_values is no list of codes",
    ),
    "no axes": (lambda f: f["speed"].attrs.__delitem__("axes"), "speed: "),
    "wrong axes": (lambda f: f["speed"].attrs.__setitem__("axes", np.bytes_("crank_angle")), "speed: "),
    "machine": (
        lambda f: f["about/machine"].write_direct(np.array([b"[a]"], f["about/machine"].dtype)),
        "about/provenance: its machine_sha256",
    ),
    "not UTF-8": (
        lambda f: f["warning"].write_direct(np.array([b"\xff"] * 3, f["warning"].dtype)),
        "warning: ",
    ),
    "control characters": (lambda f: add(f, "a\x1b[2J\nb"), r"a\\x1b\[2J b: "),
}


def replaced(file, name, **options):
    """The dataset made anew, its attributes kept."""
    attributes = {}
    for key in {"units", "long_name", "axes", "reference"} & file[name].attrs.keys():
        attribute = file[name].attrs.get_id(key)
        attributes[key] = np.empty((), attribute.dtype)
        attribute.read(attributes[key])
    del file[name]
    dataset = add(file, name, fletcher32=True, **options)
    for key, value in attributes.items():
        dataset.attrs.create(key, value, dtype=value.dtype)


@pytest.mark.parametrize("case", TAMPERED)
def test_strange_files_are_refused_in_one_line(path, case):
    tamper, message = TAMPERED[case]
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        tamper(file)
    with pytest.raises(ArchiveError, match=message) as caught:
        read(path)
    text = str(caught.value)
    assert text.startswith(str(path)) and text.isprintable() and caught.value.remedy in text
    if isinstance(caught.value, NoArchiveError):
        with pytest.raises(NoArchiveError):
            verify(path)
    else:
        assert verify(path)


def test_hostile_provenance_is_refused(path):
    for content in ("[1]", '{"a": 1}', "{", "[" * 100_000):
        with h5py.File(path, "r+") as file:
            del file["about/provenance"]
            add(
                file,
                "about/provenance",
                shape=(1,),
                dtype=f"S{len(content)}",
                chunks=(1,),
                data=[content.encode()],
            )
        with pytest.raises(ArchiveError, match="about/provenance"):
            read(path)


@pytest.mark.parametrize("part", [0.0, 0.01, 0.3, 0.9, 0.999])
def test_truncated_files_are_refused(path, part):
    content = path.read_bytes()
    path.write_bytes(content[: int(part * len(content))])
    with pytest.raises(ArchiveError, match="damaged") as caught:
        read(path)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize("seed", range(60))
def test_no_word_of_hdf5_is_in_the_message_of_a_broken_file(path, seed):
    rng, content = np.random.default_rng(seed), bytearray(path.read_bytes())
    at = int(rng.integers(len(content) - 50))
    content = content[:at] if seed % 3 == 0 else content[:at] + bytes(50) + content[at + 50 :]
    path.write_bytes(bytes(content))
    try:
        read(path)
    except ArchiveError as error:
        assert "damaged" in str(error)
        assert not any(word in str(error) for word in ("synchronously", "Unable", "Can't", "metadata", "filter", "eof"))


def test_other_files_are_refused(tmp_path):
    (tmp_path / "a.h5").write_text("run,torque\n" * 1000)
    for name in ("a.h5", "none.h5", "."):
        with pytest.raises(ArchiveError, match=str(tmp_path)):
            read(tmp_path / name)
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file["x"] = 1.0
    with pytest.raises(ArchiveError, match="is not an apesim archive"):
        read(tmp_path / "b.h5")


def test_size_limit_is_the_callers(path):
    with pytest.raises(ArchiveError, match="larger than 500 bytes"):
        read(path, limit=500)


def test_compressed_copies_are_readable(tmp_path, path):
    with h5py.File(path, "r+") as file:
        values = file["cylinder_pressure"][...]
        replaced(
            file,
            "cylinder_pressure",
            shape=values.shape,
            data=values,
            chunks=values.shape,
            shuffle=True,
            compression="gzip",
        )
    np.testing.assert_array_equal(read(path).variables["cylinder_pressure"].values, values)


def test_a_compressed_file_that_would_fill_the_memory_is_refused(path):
    count = 30_000_000
    with h5py.File(path, "r+") as file:
        replaced(file, "speed", shape=(count,), data=np.zeros(count), chunks=(count // 10,), compression="gzip")
    assert path.stat().st_size < 2**20
    with pytest.raises(ArchiveError, match="speed: the datasets are larger than 20 times the file"):
        read(path)


WITH_LITTLE_MEMORY = """
import resource, sys
from pathlib import Path
from apesim.archive import ArchiveError, read
taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (taken + 2**27, taken + 2**27))
try:
    read(sys.argv[1])
except ArchiveError as error:
    print(error)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the limit of a process is Linux's here")
def test_a_file_larger_than_the_memory_is_refused_with_a_remedy(path):
    count = 30_000_000
    with h5py.File(path, "r+") as file:
        replaced(file, "speed", shape=(count,), data=np.zeros(count), chunks=(count // 10,))
    done = subprocess.run([sys.executable, "-c", WITH_LITTLE_MEMORY, path], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert "available; free some memory" in done.stdout


def test_errors_travel_between_processes():
    error = pickle.loads(pickle.dumps(ArchiveError("f", "what", "remedy")))
    assert str(error) == "f: what; remedy"
