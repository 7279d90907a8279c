"""Order of rows: an angle that wraps goes on, and what else does not rise is named with what to do."""

from pathlib import Path

import numpy as np
import pytest

from apesim.quantities import InputError
from apesim.studies.measured import read_measured
from tests.machines import AMBIENT

BENCHES = {
    "valve": 'bench = "valve"\n[[run]]\ndata = "a.csv"\nsupply = "0.40 MPa gauge"\npulse = "50 ms"\n',
    "engine": 'bench = "engine"\n[[run]]\ndata = "a.csv"\nsupply = "1.0 MPa gauge"\nspeed = "600 rpm"\n'
    'energise = "-10 deg"\nrelease = "70 deg"\n',
}
SHOT = np.arange(-2.0, 18.0)
"""Times of a record [ms]."""


def read(folder, places, lifts=None, header="time [ms]"):
    """The run of a file with these rows, and what is said of it."""
    lifts = np.arange(len(places)) if lifts is None else lifts
    text = "".join(f"{place!r},{lift!r}\n" for place, lift in zip(map(float, places), map(float, lifts), strict=True))
    Path(folder, "a.csv").write_text(f"{header},lift [mm]\n{text}")
    Path(folder, "measured.toml").write_text(BENCHES["valve" if "time" in header else "engine"])
    measured = read_measured(folder, AMBIENT)
    return measured.runs[0], measured.hints


def refused(folder, *arguments, **named):
    """The one line of a refusal, less the path of the folder."""
    with pytest.raises(InputError) as caught:
        read(folder, *arguments, **named)
    [line] = str(caught.value).replace(f"{folder}/", "").splitlines()
    return line


@pytest.mark.parametrize(
    ("places", "words"),
    [
        (np.tile(SHOT, 2), "falls back to -2 ms in row 21: two records, one after the other; save each in a file"),
        (np.tile(SHOT, 5), "falls back to -2 ms in row 21: 5 segments of 20 rows; save each in a file"),
        (np.append(SHOT, np.tile(SHOT[3:], 2)), "falls back to 1 ms in row 21: 3 records, one after the other; save"),
        (SHOT[::-1], "falls from row to row; turn the order of the rows round"),
        (np.append(SHOT[9:], SHOT[:9]), "does not rise in row 12; sort the rows"),
        (np.insert(SHOT, 5, 0.5), "does not rise in row 6; sort the rows"),
        (np.insert(SHOT, 5, SHOT[4]), "does not rise in row 6; sort the rows, one of equals"),
        (np.floor(SHOT / 3.0), "stands in several rows at once; write it with more digits, or sample_interval"),
    ],
)
def test_what_does_not_rise_is_named(tmp_path, places, words):
    assert words in refused(tmp_path, places)


def test_pairs_of_an_oscilloscope_are_told_from_times_with_too_few_digits(tmp_path):
    noise = np.random.default_rng(1).normal(size=40)
    pairs = np.sort(noise.reshape(20, 2)).ravel()
    line = refused(tmp_path, np.repeat(SHOT, 2), pairs)
    assert "stands in two rows, of smallest and largest values; record without peak detection" in line
    assert "write it with more digits" in refused(tmp_path, np.repeat(SHOT, 2), noise)


@pytest.mark.parametrize(
    ("angles", "times"),
    [
        (np.arange(200.0, 1100.0, 2.0) % 360.0, 3),
        ((np.arange(0.0, 720.0, 2.0) + 180.0) % 360.0 - 180.0, 1),
        (np.arange(100.0, 900.0, 0.5) % 720.0, 1),
        (np.delete(np.arange(300.0, 500.0) % 360.0, [59, 60]), 1),
    ],
)
def test_an_angle_that_wraps_goes_on(tmp_path, angles, times):
    run, hints = read(tmp_path, angles, header="crank_angle [deg]")
    assert np.all(np.diff(run.angles) > 0.0) and np.all(np.diff(run.angles) < np.radians(5.0))
    assert np.degrees(run.angles[0]) == pytest.approx(angles[0])
    assert (np.degrees(run.angles) - angles) % 360.0 % 359.9999999 == pytest.approx(0.0, abs=1e-6)
    [hint] = hints
    assert hint.startswith("a.csv: crank_angle falls back by ") and hint.endswith("; it is read as going on")
    assert (f"{times} times, first in row" in hint) == (times > 1)


def test_windows_of_the_angle_are_no_turn(tmp_path):
    line = refused(tmp_path, np.tile(np.arange(100.0, 200.0), 2), header="crank_angle [deg]")
    assert "crank_angle: falls back to 100 deg in row 101: two records" in line


@pytest.mark.parametrize(
    ("header", "angles", "words"),
    [
        ("crank_angle [rad]", np.arange(0.0, 720.0), "its rows are 57.3 deg apart; is its unit right?"),
        ("crank_angle [rad]", np.tile(np.arange(0.0, 360.0), 2), "its rows are 57.3 deg apart; is its unit right?"),
        ("crank_angle [r]", np.arange(0.0, 9.0), "its rows are 360 deg apart; is its unit right?"),
        ("crank_angle [rad]", np.arange(0.0, 720.0, 0.1), "115 turns with 62.8 rows each; is its unit right?"),
        ("crank_angle [Grad]", np.arange(0.0, 360.0), "'Grad' is no known unit; write \"crank_angle [deg]\""),
        ("crank_angle (Grad)", np.arange(0.0, 360.0), "'Grad' is no known unit; write \"crank_angle [deg]\""),
    ],
)
def test_an_angle_of_the_wrong_unit_is_refused(tmp_path, header, angles, words):
    assert f"a.csv: crank_angle: {words}" in refused(tmp_path, angles, header=header)


def test_a_coarse_turn_is_read(tmp_path):
    run, hints = read(tmp_path, np.arange(0.0, 390.0, 30.0), header="crank_angle [deg]")
    assert len(run.angles) == 13 and hints == ()
