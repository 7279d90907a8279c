"""Faults of bad input, as they are shown."""

from apesim.quantities import Fault, parse
from tests.apesim.quantities.samples import STROKE, SUPPLY, faults_of


def test_a_culprit_is_one_line():
    fault = Fault("a\nb.toml", "x\r\ny", "'\x1b[31m'", "\udc80 ok\u2028")
    assert str(fault) == "a\\nb.toml: x\\r\\ny: '\\x1b[31m'; \\udc80 ok\\u2028"
    assert str(Fault("", "", "wrong", "right")) == "wrong; right"
    faults_of(parse, "9\nmm\n" * 100, STROKE)
    faults_of(parse, "9 MPa\x0bgauge", SUPPLY)
