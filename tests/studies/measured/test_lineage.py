"""The lineage of a machine: it tells data from other data, in any encoding."""

import pytest

from apesim.archive import sha256
from apesim.engine.machine import Machine
from apesim.quantities.settings import dumps
from apesim.studies.measured import lineage, read_measured
from apesim.studies.measured.lineage import find_lineage

ABOUT = '[[run]]\ndata = "a.csv"\nsupply = "5 bar abs"\npulse = "50 ms"\n'
TEXT = "time [ms];lift [µm]\n" + "".join(f"{t};{t},5\n" for t in range(10))


def digest_of(folder, data):
    """The digest of a folder with these bytes as its data."""
    (folder / "measured.toml").write_text(f'bench = "valve"\n{ABOUT}')
    (folder / "a.csv").write_bytes(data)
    return find_lineage(read_measured(folder), dumps(Machine()), Machine())["measured_data_sha256"]


def test_the_digest_is_that_of_the_text_and_no_end_of_line_changes_it(tmp_path, monkeypatch):
    expected = sha256(sha256(f'bench = "valve"\n{ABOUT}') + sha256(TEXT))
    for size in (1, 7, 1 << 22):
        monkeypatch.setattr(lineage, "HASHED_BYTES", size)
        for end in ("\n", "\r\n", "\r"):
            assert digest_of(tmp_path, TEXT.replace("\n", end).encode()) == expected


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16"])
def test_data_in_any_encoding_have_a_digest(tmp_path, encoding):
    first, second = (digest_of(tmp_path, text.encode(encoding)) for text in (TEXT, TEXT.replace("9,5", "9,6")))
    assert len(first) == 64 and first != second
