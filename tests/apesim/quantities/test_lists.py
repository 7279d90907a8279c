"""Lists of a quantity: read from one text, checked number by number, printed without loss."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest

from apesim.quantities import NO_LIST, InputError, InvalidValue, Quantity, QuantityList
from apesim.quantities.settings import dumps, load, replaced
from apesim.quantities.trees import contents_of

ANGLES = QuantityList(Quantity("deg", 0, 360, "chosen"), 4, "chosen", text="evenly spread")


class Machine(NamedTuple):
    """Machine with a list."""

    angles: Annotated[np.ndarray, ANGLES] = NO_LIST


@pytest.mark.parametrize(
    ("raw", "degrees"),
    [
        ("0, 120, 240 deg", [0, 120, 240]),
        ("0:240:120 deg", [0, 120, 240]),
        ("90 deg", [90]),
        (["0 deg", "0.25 r"], [0, 90]),
        (" ", []),
    ],
)
def test_a_list_is_read_from_a_text_a_range_or_texts(raw, degrees):
    assert np.degrees(ANGLES.read(raw)) == pytest.approx(degrees, rel=1e-15)


def test_a_list_is_printed_and_read_back_bit_for_bit(tmp_path):
    path, angles = tmp_path / "machine.toml", np.array([0.1, 1.0 / 3.0, np.nextafter(2.0, 3.0)])
    path.write_text(dumps(Machine(angles)))
    assert load(Machine, path).angles.tobytes() == angles.tobytes()
    assert '# angles = ""  # default: evenly spread;' in dumps(Machine())
    path.write_text(dumps(Machine()))
    assert contents_of(load(Machine, path)) == contents_of(Machine())


@pytest.mark.parametrize(
    ("raw", "told"),
    [
        ("0, 120", ["'0' has no unit", "' 120' has no unit"]),
        ("0, 400 deg", ["' 400 deg' is out of range; allowed: 0 to 360 deg"]),
        ("0, 2 mm", ["'mm' cannot be converted to deg"] * 2),
        ("0,120,240 deg", ['which may be a decimal one; write "0, 120, 240 deg"']),
        ("0, 1, 2, 3, 4 deg", ["5 numbers are too many; give at most 4"]),
        ([0, 1], ["0 has no unit", "1 has no unit"]),
        (3, ['3 is no list; write e.g. "0, 180 deg"']),
        ([], ["is no list of 1 to"]),
    ],
)
def test_every_number_that_is_refused_is_told(raw, told, tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(f"angles = {raw!r}\n".replace("'", '"'))
    with pytest.raises(InputError) as caught:
        load(Machine, path)
    lines = str(caught.value).splitlines()
    assert len(lines) == len(told) and all(line.startswith(f"{path}: angles: ") for line in lines)
    assert all(part in line for part, line in zip(told, lines, strict=True))


def test_from_python_numbers_have_their_unit_beside_them():
    two = replaced(Machine(), {"angles": ([0, 180], "deg")}, "with_()").angles
    assert two.tolist() == [0.0, np.pi]
    assert replaced(Machine(two), {"angles": ()}, "with_()").angles.size == 0
    with pytest.raises(InputError, match=r'with_\(\): angles: .* has no unit; write e.g. \(\[0, 1\], "deg"\)'):
        replaced(Machine(), {"angles": [0, 1]}, "with_()")
    with pytest.raises(InputError, match="5 numbers are too many"):
        replaced(Machine(), {"angles": (range(5), "deg")}, "with_()")


@pytest.mark.parametrize("wrong", [np.zeros((2, 2)), [7.0], ["0 deg"], np.full(5, 0.0), [np.nan], 1.0])
def test_an_array_that_no_text_gives_is_refused(wrong):
    with pytest.raises(InvalidValue):
        ANGLES.check(wrong)


def test_a_checked_list_becomes_an_array_of_floats():
    assert ANGLES.convert([1, 2]).dtype == float
    array = np.array([1.0, 2.0])
    assert ANGLES.convert(array) is array
