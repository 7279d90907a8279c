"""How many damages to archives were tried, and what became of them."""

from collections import Counter

import h5py

from docs.results import Number, Table, describe_code
from docs.results._campaign import try_out
from tests.campaigns import archives

RECORD = True
TRIALS = 300 * len(archives.DAMAGES)
REFUSED, AS_BEFORE, NOTED, UNSEEN = "refused", "reads as before", "the root digest is another one", "broken"
HEADS = {
    REFUSED: "refused, and named by `archive verify`",
    AS_BEFORE: "reads as it was written",
    NOTED: "shows against the noted digest",
    UNSEEN: "a promise broken",
}


def compute():
    """Counts of outcomes by the kind of damage."""
    found = try_out(archives, TRIALS)
    counts = Counter()
    for one in found.values():
        kind, _, word = one.word.partition(": ")
        counts[kind, UNSEEN if one.is_broken else word] += 1
    rows = [
        [damage.__doc__.removesuffix("."), *(Number(counts[damage.__name__, word]) for word in HEADS)]
        for damage in archives.DAMAGES
    ]
    broken = sum(one.is_broken for one in found.values())
    counted = sum(number for (_, word), number in counts.items() if word in (REFUSED, UNSEEN))
    return {
        "trials": Number(TRIALS),
        "kinds": Number(len(archives.DAMAGES)),
        "broken": Number(broken),
        "counted": Number(counted),
        "noted": Number(sum(number for (_, word), number in counts.items() if word == NOTED)),
        "outcomes": Table(["damage", *HEADS.values()], rows),
        "made": Table(
            ["what", "value"],
            [*describe_code(), ["HDF5", h5py.version.hdf5_version], ["h5py", h5py.version.version]],
        ),
    }
