"""Declarations of every kind, and the faults that a reader finds."""

import math

import pytest

from apesim.quantities import Choice, Curve, InputError, Pressure, Quantity

STROKE = Quantity("mm", 1, 50, "Table 1")
SPEED = Quantity("rpm", 0, 3000, "chosen")
ANGLE = Quantity("deg", -180, 180, "chosen")
RATIO = Quantity("", 1, 50, "Table 1")
PORTS = Quantity("", 1, 100, "here", whole=True)
VOLUME = Quantity("L", 0, math.inf, "chosen")
TEMPERATURE = Quantity("K", 200, 350, "20 °C")
SUPPLY = Pressure(0.02, 30, "chosen")
GAUGE = Pressure(0.02, 30, "chosen", show="gauge")
OPTIONAL = Quantity("mm", 1, 50, "chosen", text="the stroke's", optional=True)
INTAKE = Choice(("epv", "cam", "ideal"), "chosen")
CURVE = Curve(("time [ms]", "opening [-]"), "a discharge test")
AMBIENT = 101325.0


def faults_of(function, *arguments, **named):
    with pytest.raises(InputError) as caught:
        function(*arguments, **named)
    assert len(str(caught.value).splitlines()) == len(caught.value.faults)
    return caught.value.faults
