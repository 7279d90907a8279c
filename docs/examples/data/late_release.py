"""Solenoids that let go later than they pull in: their coils hold the current for a while after the voltage is off."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.valve.solenoid import shifted


class LateRelease(NamedTuple):
    """A delay of both solenoids, as they are released alone."""

    time: Annotated[float, Quantity("ms", -1, 2, "a diode across a coil holds its current for some milliseconds")] = 0.0


def adjust(effect, actuator, tables):
    """f_r(t) -> f_r(t - time); f_r is the share of the way back over the time t after a release."""
    a, b = (
        curves._replace(release=shifted(curves.release, effect.time)) for curves in (tables.curves_a, tables.curves_b)
    )
    return actuator, tables._replace(curves_a=a, curves_b=b)


EFFECT = Effect(
    "late_release",
    LateRelease,
    equation="f_r(t) = f_r(t - time)",
    source="ISO 12238: a valve has one time to switch on and another one to switch off",
    seen_in="closing against opening; confused with the recorder's clock if all pulses are alike",
    isolated_by="pulses of two lengths, one three times the other, or the coil current on a channel of its own",
    adjust=adjust,
    layer="valve",
)
