"""How many damages to archives were tried, and what became of them."""

import datetime
import tempfile
from collections import Counter

import h5py

from docs.results import Number, Table
from tests.campaigns import archives
from tests.campaigns.campaign import run_campaign

LONG = True
TRIALS = 300 * len(archives.DAMAGES)
JOBS = 2
REFUSED, AS_BEFORE, NOTED, UNSEEN = "refused", "reads as before", "the root digest is another one", "broken"
HEADS = {
    REFUSED: "refused, and named by `archive verify`",
    AS_BEFORE: "reads as it was written",
    NOTED: "shows against the noted digest",
    UNSEEN: "a promise broken",
}


def compute():
    """Counts of outcomes by the kind of damage."""
    with tempfile.TemporaryDirectory() as folder:
        found = run_campaign(archives.__name__, range(TRIALS), folder, JOBS)
    counts = Counter()
    for one in found.values():
        kind, _, word = one.word.partition(": ")
        counts[kind, UNSEEN if one.is_broken else word] += 1
    rows = [
        [damage.__doc__.removesuffix("."), *(Number(counts[damage.__name__, word]) for word in HEADS)]
        for damage in archives.DAMAGES
    ]
    broken = sum(one.is_broken for one in found.values())
    changed = sum(number for (_, word), number in counts.items() if word != AS_BEFORE)
    return {
        "trials": Number(TRIALS),
        "kinds": Number(len(archives.DAMAGES)),
        "broken": Number(broken),
        "changed": Number(changed),
        "outcomes": Table(["damage", *HEADS.values()], rows),
        "made": Table(
            ["date", "HDF5", "h5py"],
            [[datetime.date.today().isoformat(), h5py.version.hdf5_version, h5py.version.version]],
        ),
    }
