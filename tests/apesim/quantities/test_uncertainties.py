"""How far a number is known: what is written reads back, what is no standard deviation is refused with a right form."""

import pytest

from apesim.quantities import InvalidValue, Quantity
from apesim.quantities.uncertainties import Uncertainty, format_uncertainty, read_uncertainty
from tests.apesim.quantities.samples import STROKE, TEMPERATURE

RATIO = Quantity("", 1.05, 1.67, "air")
PRESSURE = Quantity("kPa", 10.0, 200.0, "chosen")


@pytest.mark.parametrize(
    ("raw", "declaration", "right"),
    [
        ("0.05 mm", STROKE, Uncertainty(5e-5)),
        ("50 µm", STROKE, Uncertainty(5e-5)),
        ("1 %", STROKE, Uncertainty(0.01, is_share=True)),
        ("0.5 percent", STROKE, Uncertainty(0.005, is_share=True)),
        ("0 %", STROKE, Uncertainty(0.0)),
        ("0 mm", STROKE, Uncertainty(0.0)),
        ("exact", STROKE, Uncertainty(0.0)),
        (0.003, RATIO, Uncertainty(0.003)),
        ("0.003", RATIO, Uncertainty(0.003)),
        ("1 %", RATIO, Uncertainty(0.01, is_share=True)),
        ("2 K", TEMPERATURE, Uncertainty(2.0)),
        ("5 mbar", PRESSURE, Uncertainty(500.0)),
    ],
)
def test_a_standard_deviation_is_read_and_written(raw, declaration, right):
    found = read_uncertainty(raw, declaration)
    assert found == right
    assert read_uncertainty(format_uncertainty(found, declaration), declaration) == pytest.approx(right)


@pytest.mark.parametrize(
    ("raw", "declaration", "wrong", "right"),
    [
        ("0.05", STROKE, "'0.05' has no unit", 'write e.g. "1 %" or "0.09 mm"'),
        (0.05, STROKE, "0.05 has no unit", 'write e.g. "1 %" or "0.09 mm"'),
        ("0.05 kg", STROKE, "'0.05 kg': 'kg' cannot be converted to mm", 'write e.g. "1 %" or "0.09 mm"'),
        ("0.05 mmm", STROKE, "'0.05 mmm': 'mmm' is no known unit", 'write "0.05 mm"'),
        ("-1 %", STROKE, "'-1 %' is negative", 'write e.g. "1 %" or "0.09 mm", or "exact"'),
        ("150 %", STROKE, "'150 %' is out of range", "allowed: 0 to 100 %"),
        ("9 m", STROKE, "'9 m' is wider than the range itself, 1 to 50 mm", 'write e.g. "1 %" or "0.09 mm"'),
        ("well", STROKE, "'well' is no standard deviation", 'write e.g. "1 %" or "0.09 mm"'),
        (True, STROKE, "True is no standard deviation", 'write e.g. "1 %" or "0.09 mm"'),
        ([1], STROKE, "[1] is no standard deviation", 'write e.g. "1 %" or "0.09 mm"'),
        ("1 %", TEMPERATURE, "'1 %' is a share of a temperature", 'write e.g. "2.9 K"'),
        ("2 degC", TEMPERATURE, "'2 degC': a difference of temperatures is in K", 'write e.g. "2.9 K"'),
        ("2 kPa gauge", PRESSURE, "'2 kPa gauge': a difference is neither gauge nor abs", 'write "2 kPa"'),
        ("1 mm", RATIO, "'1 mm': 'mm' cannot be converted to a share", 'write e.g. "1 %" or 0.014'),
    ],
)
def test_what_is_no_standard_deviation_is_refused_with_a_right_form(raw, declaration, wrong, right):
    value = {id(STROKE): 9e-3, id(TEMPERATURE): 287.0, id(RATIO): 1.4}.get(id(declaration), 1e5)
    with pytest.raises(InvalidValue) as caught:
        read_uncertainty(raw, declaration, value)
    assert (caught.value.wrong, caught.value.right) == (wrong, right)
