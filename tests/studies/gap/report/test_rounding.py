"""Digits that the error of a number leaves it."""

import pytest

from apesim.studies.gap.report.effect_rows import format_interval, format_value
from apesim.studies.gap.report.html import format_pull
from apesim.studies.gap.report.rounding import find_error, format_chance, format_sigmas, format_size, round_to_error


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.7974, 0.0022, "0.797"),
        (-1.96, 0.5, "-2.0"),
        (1234.5, 60.0, "1230"),
        (3.3e-7, 2e-8, "3.3e-07"),
        (0.02, 3.0, "0"),
        (0.0, 0.1, "0"),
        (9.99, 0.1, "10.0"),
        (2 / 3, 1e-12, "0.666667"),
        (2 / 3, None, "0.67"),
        (2 / 3, 0.0, "0.67"),
    ],
)
def test_the_last_digit_is_the_first_of_the_error(value, error, text):
    assert round_to_error(value, error) == text


def test_an_effect_has_the_digits_that_its_interval_leaves():
    row = {"name": "release_delay", "parameter": "time", "value": 0.7974, "unit": "ms"}
    row |= {"interval_95": [0.79312, 0.80168], "open_ends": []}
    assert (format_value(row), format_interval(row)) == ("0.797 ms", "95 % interval 0.793 to 0.802 ms")
    wide = row | {"interval_95": [0.3, 1.3]}
    assert (format_value(wide), format_interval(wide)) == ("0.8 ms", "95 % interval 0.3 to 1.3 ms")


def test_an_interval_that_is_open_on_one_side_gives_the_error_by_the_other():
    assert find_error(2.0, [0.0, 3.96], ["low"]) == pytest.approx(1.0, rel=1e-3)
    assert find_error(2.0, [0.0, 3.96], ["low", "high"]) is None


def test_sizes_sigmas_chances_and_pulls_have_the_digits_of_their_scatter():
    assert [format_size(1.2345, n) for n in (4, 50, 5000)] == ["1.2", "1.2", "1.23"]
    assert [format_sigmas(x) for x in (0.3, -0.3, 41.7)] == ["0", "0", "42"]
    chances = [format_chance(p, 20000) for p in (1.0, 0.314159, 0.00031, 5e-5)]
    assert chances == ["1.0", "0.31", "0.0003", "below 0.0001"]
    assert format_pull({"deviations": -8.26, "deviations_error": 0.4}) == "-8.3"
