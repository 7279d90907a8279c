"""A crank that turns unevenly, under a recorder that knows but one mark a turn."""

from math import isnan
from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.reading import moved


class SpeedRipple(NamedTuple):
    """Share of the mean speed by which the crank's swings."""

    share: Annotated[float, Quantity("", 0, 0.04, "a single cylinder on a light flywheel: 0.005 to 0.03")] = 0.0


def sensor(effect, reading):
    """Record over angles that grow with time, evenly from one top dead centre to the next.

    Parameters
    ----------
    effect : SpeedRipple
    reading : apesim.reading.Reading

    Returns
    -------
    apesim.reading.Reading
    """

    def instants(times):
        return (true_angle(effect.share, reading.start + reading.speed * times) - reading.start) / reading.speed

    return reading if isnan(reading.speed) else moved(reading, instants)


def true_angle(share, recorded):
    """Crank angle, where the recorded one grows evenly in time; both agree at top dead centre.

    ``d true/dt = speed (1 + share sin(true)) / sqrt(1 - share^2)`` is, with the crank a quarter of a turn on, the
    relation of eccentric and true anomaly in an ellipse of that eccentricity, and solved as that is.

    Parameters
    ----------
    share : float
    recorded : (n,) float array
        [rad]

    Returns
    -------
    (n,) float array
    """
    bent = share / (1.0 + np.sqrt(1.0 - share**2))
    anomaly = recorded + 0.5 * np.pi + 2.0 * np.arctan(bent)
    return anomaly - 2.0 * np.arctan(bent * np.sin(anomaly) / (1.0 + bent * np.cos(anomaly))) - 0.5 * np.pi


EFFECT = Effect(
    "speed_ripple",
    SpeedRipple,
    equation="recorded(phi) = x(psi), d psi/d phi = (1 + share sin psi)/sqrt(1 - share^2), psi = phi at 0",
    source="Heywood, Internal Combustion Engine Fundamentals, 9.2; Kepler's equation",
    seen_in="phase of the cylinder pressure, most around bottom dead centre",
    isolated_by="an encoder with many marks a turn",
    sensor=sensor,
)
