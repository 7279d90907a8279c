"""Archives that are damaged: bits, words and blocks of the file, and edits by a program that knows HDF5.

Whatever is changed, reading gives what was written or refuses the file, and `archive verify` names what reading
refuses. Who writes all of it anew, digests too, is seen by the root digest alone that was noted when the archive was
made.
"""

import random
import tempfile
from functools import cache
from pathlib import Path

import h5py
import numpy as np

from apesim.archive import ArchiveError
from apesim.archive.file import read, read_digest, write
from apesim.archive.inspection import verify
from tests.archive_samples import VERSION_2, VERSION_2_SWEEP, same, sample

from .campaign import Outcome, trial_folder

BLOCK = 512
"""Bytes that a disk writes at once."""
WORDS = 2, 4, 8
"""Bytes of a word."""


def trial(seed):
    """Damage an archive, and read it.

    Parameters
    ----------
    seed : int

    Returns
    -------
    Outcome
    """
    rng = random.Random(seed)
    damage = DAMAGES[seed % len(DAMAGES)]
    content = rng.choice(archives())
    with trial_folder() as folder:
        (folder / "whole.h5").write_bytes(content)
        (folder / "f.h5").write_bytes(content)
        damage(folder / "f.h5", rng)
        return judge(damage, folder / "whole.h5", folder / "f.h5")


def judge(damage, whole, damaged):
    """The outcome of a damage by what is read.

    Parameters
    ----------
    damage : function
        Of `DAMAGES`; the outcome tells its kind by its docstring.
    whole, damaged : path

    Returns
    -------
    Outcome
    """
    kind = damage.__doc__.removesuffix(".")
    try:
        found = read(damaged)
    except ArchiveError as error:
        named = verify(damaged)
        if not named:
            return Outcome(f"{kind}: verify finds nothing", True, str(error))
        return Outcome(f"{kind}: refused")
    except Exception as error:
        return Outcome(f"{kind}: ends with {type(error).__name__}", True, str(error))
    before = read(whole)
    if same(before, found) and before.provenance == found.provenance:
        return Outcome(f"{kind}: reads as before", is_void=True)
    if damage is rewrite and read_digest(damaged) != read_digest(whole):
        return Outcome(f"{kind}: the root digest is another one", is_void=True)
    return Outcome(f"{kind}: changed unseen", True)


@cache
def archives():
    """Bytes of archives with digests, old and new."""
    with tempfile.TemporaryDirectory() as folder:
        small, large = (write(sample(runs, angles), Path(folder, f"{angles}.h5")) for runs, angles in SIZES)
        return [path.read_bytes() for path in (VERSION_2, VERSION_2_SWEEP, small, large)]


SIZES = ((0, 1, 2), 5), (tuple(range(40)), 721)
"""Runs and crank angles of the new archives."""


# --- bytes ---


def flip_bit(path, rng):
    """One bit of the file."""
    data = bytearray(path.read_bytes())
    data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    path.write_bytes(data)


def fill_word(path, rng):
    """A word of zeros or ones, which sums of Fletcher's kind take for one another."""
    data, size = bytearray(path.read_bytes()), rng.choice(WORDS)
    place = rng.randrange(len(data) // size) * size
    data[place : place + size] = rng.choice((b"\x00", b"\xff")) * size
    path.write_bytes(data)


def turn_word(path, rng):
    """A word 0000 where FFFF stands, or the other way round, where there is one."""
    data = bytearray(path.read_bytes())
    places = [n for n in range(0, len(data) - 1, 2) if data[n : n + 2] in (b"\x00\x00", b"\xff\xff")]
    place = rng.choice(places)
    data[place : place + 2] = b"\xff\xff" if data[place] == 0 else b"\x00\x00"
    path.write_bytes(data)


def swap_words(path, rng):
    """Two words change places."""
    data, size = bytearray(path.read_bytes()), rng.choice(WORDS)
    first, second = (rng.randrange(len(data) // size) * size for _ in range(2))
    one, other = bytes(data[first : first + size]), bytes(data[second : second + size])
    data[first : first + size], data[second : second + size] = other, one
    path.write_bytes(data)


def move_block(path, rng):
    """A block is written where another one belongs."""
    data = bytearray(path.read_bytes())
    source, target = (rng.randrange(max(len(data) // BLOCK, 1)) * BLOCK for _ in range(2))
    data[target : target + BLOCK] = bytes(data[source : source + BLOCK])
    path.write_bytes(data)


def lose_block(path, rng):
    """A block of zeros."""
    data = bytearray(path.read_bytes())
    place = rng.randrange(max(len(data) // BLOCK, 1)) * BLOCK
    length = len(data[place : place + BLOCK])
    data[place : place + length] = bytes(length)
    path.write_bytes(data)


def cut_off(path, rng):
    """The end of the file is missing."""
    data = path.read_bytes()
    path.write_bytes(data[: rng.randrange(len(data))])


def append(path, rng):
    """Something stands behind the end."""
    path.write_bytes(path.read_bytes() + rng.randbytes(rng.choice((1, 8, BLOCK))))


def change_bytes(path, rng):
    """Some bytes at random places."""
    data = bytearray(path.read_bytes())
    for _ in range(rng.choice((2, 5, 20))):
        data[rng.randrange(len(data))] = rng.randrange(256)
    path.write_bytes(data)


# --- edits ---


def datasets(file):
    """Paths of all datasets."""
    found = []
    file.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None)
    return found


def other_value(value, rng):
    """Another value of the same type."""
    if isinstance(value, bytes):
        return rng.randbytes(len(value)).replace(b"\x00", b"x") or b"x"
    if np.issubdtype(value.dtype, np.floating):
        return rng.choice((0.0, -value, np.nextafter(value, np.inf), value * (1.0 + 1e-12), rng.gauss(0.0, 1e5)))
    return value.dtype.type(rng.choice((0, 1, 2, int(value) ^ 1)))


def set_value(path, rng):
    """One value of a dataset."""
    with h5py.File(path, "r+") as file:
        values = file[rng.choice(datasets(file))]
        place = tuple(rng.randrange(length) for length in values.shape)
        values[place] = other_value(values[place], rng)


def set_attribute(path, rng):
    """One attribute of a dataset or of the root."""
    with h5py.File(path, "r+") as file:
        item = file[rng.choice([*datasets(file), "/"])]
        names = [name for name in item.attrs if name not in ("DIMENSION_LIST", "REFERENCE_LIST")]
        if names:
            name = rng.choice(names)
            if rng.random() < 0.3:
                del item.attrs[name]
            else:
                item.attrs[name] = rng.choice(("", "m", "Pa abs", "kPa abs", "rpm", 1, 0, "run", "0 cam, 1 epv"))


def swap_values(path, rng):
    """Two datasets of one shape and type change their values."""
    with h5py.File(path, "r+") as file:
        groups = {}
        for name in datasets(file):
            groups.setdefault((file[name].shape, file[name].dtype.str), []).append(name)
        first, second = rng.sample(rng.choice([names for names in groups.values() if len(names) > 1]), 2)
        file[first][()], file[second][()] = file[second][()], file[first][()]


def swap_names(path, rng):
    """Two datasets change their names."""
    with h5py.File(path, "r+") as file:
        first, second = rng.sample([name for name in datasets(file) if not name.startswith("about/")], 2)
        file.move(first, "between")
        file.move(second, first)
        file.move("between", second)


def turn_rows(path, rng):
    """The rows of a dataset stand in another order."""
    with h5py.File(path, "r+") as file:
        values = file[rng.choice([name for name in datasets(file) if file[name].ndim])]
        values[()] = np.roll(values[()], rng.randrange(1, max(len(values), 2)), axis=0)


def remove(path, rng):
    """A dataset is taken out."""
    with h5py.File(path, "r+") as file:
        del file[rng.choice(datasets(file))]


def add(path, rng):
    """A dataset is put in, with the attributes of another one."""
    with h5py.File(path, "r+") as file:
        file.copy(rng.choice(datasets(file)), rng.choice(("more", "about/more", "brake_power")))


def rewrite(path, rng):
    """A value is changed, and all is written anew with digests that fit."""
    archive = read(path)
    name = rng.choice([name for name, each in archive.variables.items() if name != "run" and each.kind == "float64"])
    values = archive.variables[name].values
    place = tuple(rng.randrange(length) for length in values.shape)
    values.setflags(write=True)
    values[place] += 1.0
    write(archive, path)


BYTES = flip_bit, fill_word, turn_word, swap_words, move_block, lose_block, cut_off, append, change_bytes
EDITS = set_value, set_attribute, swap_values, swap_names, turn_rows, remove, add, rewrite
DAMAGES = (*BYTES, *EDITS)
