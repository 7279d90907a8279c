"""Text files and the headers of their columns."""

from apesim.quantities import split_header


def test_split_header():
    assert split_header(" lift  [mm] ") == ("lift", "mm")
    assert split_header("pressure_a [kPa abs]") == ("pressure_a", "kPa abs")
    assert split_header("lift") == ("lift", None)
