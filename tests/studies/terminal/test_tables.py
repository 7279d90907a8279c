"""Tables say what they are told, and traces are written completely or not at all."""

import os

import numpy as np
import pytest

from apesim.archive import ArchiveError
from apesim.studies.execution.output import write_traces
from apesim.studies.terminal.console import Console
from apesim.studies.terminal.tables import table_of

HEADER, ROWS = ("time [s]", "lift [m]"), np.array([[0.0, 0.1], [1e-4, 1.0 / 3.0]])
TEXT = "time [s],lift [m]\n0.0,0.1\n0.0001,0.3333333333333333\n"


def test_a_file_that_is_replaced_is_never_cut_short(tmp_path):
    path, before = tmp_path / "traces.csv", tmp_path / "before.csv"
    path.write_text("what was there")
    os.link(path, before)
    write_traces(path, HEADER, ROWS)
    assert path.read_text() == TEXT
    assert before.read_text() == "what was there"
    assert sorted(tmp_path.iterdir()) == [before, path]


def test_a_folder_that_is_missing_is_told(tmp_path):
    with pytest.raises(ArchiveError, match="could not be written"):
        write_traces(tmp_path / "no" / "traces.csv", HEADER, ROWS)


def test_a_unit_in_brackets_is_text_wherever_it_stands(capsys):
    Console().result({}, table_of("air [kg/kWh]", ("speed [deg]", "x"), [("a [bar]", "1")]))
    shown = capsys.readouterr().out
    assert all(text in shown for text in ("air [kg/kWh]", "speed [deg]", "a [bar]"))
