"""Crank that turns unevenly, recorded by an encoder with one mark a turn."""

from math import isnan
from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.reading import Reading, moved


class SpeedRipple(NamedTuple):
    """Swing of the crank's speed, as a share of its mean."""

    share: Annotated[float, Quantity("", 0, 0.04, "a single cylinder on a light flywheel: 0.005 to 0.03")] = 0.0


def sensor(effect: SpeedRipple, reading: Reading) -> Reading:
    """Record the channels over angles that grow evenly in time from one top dead centre to the next.

    `reading` is what the sensors would record without the effect; without a speed, as on a bench, it is returned as it
    is.

    A channel that shows the true angle reads 3.182 rad where the record says pi:

    >>> reading = Reading(at=lambda times: {"angle": 100.0 * times}, speed=100.0, start=0.0)
    >>> sensor(SpeedRipple(share=0.02), reading).at(np.array([0.01 * np.pi]))["angle"].round(3).tolist()
    [3.182]
    """

    def instants(times: np.ndarray) -> np.ndarray:
        return (true_angle(effect.share, reading.start + reading.speed * times) - reading.start) / reading.speed

    return reading if isnan(reading.speed) else moved(reading, instants)


def true_angle(share: float, recorded: np.ndarray) -> np.ndarray:
    """True crank angle at an angle that grows evenly in time; both agree at top dead centre.

    ``d psi/d phi = (1 + share sin(psi))/sqrt(1 - share^2)`` gives the true angle psi over the recorded one phi. With
    the crank a quarter of a turn on, this is the relation of eccentric and true anomaly in an ellipse (Kepler's
    equation), and is solved in the same closed form [1]_.

    Parameters
    ----------
    share : float
        Swing of the speed, as a share of its mean; from 0 up to 1.
    recorded : (n,) float array
        Recorded crank angles [rad].

    Returns
    -------
    (n,) float array
        True crank angles [rad].

    References
    ----------
    .. [1] R. Broucke and P. Cefola, "A note on the relations between true and eccentric anomalies in the two-body
       problem", Celestial Mechanics 7, 1973, pp. 388-389.

    Examples
    --------
    Half a turn after top dead centre the swing of 0.02 has added twice its size:

    >>> (true_angle(0.02, np.array([0.0, np.pi, 2.0 * np.pi])) - [0.0, np.pi, 2.0 * np.pi]).round(3).tolist()
    [0.0, 0.04, 0.0]
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
