"""Slider and crank with pin offset: cylinder volume over crank angle.

Crank angle 0 is crank pin up: top dead centre (TDC) without offset. The offset is positive towards the side to which
the crank pin moves after 0.
"""

from math import cos, pi, sin, sqrt
from typing import NamedTuple

from apesim.kernel import kernel


@kernel
def piston_face(engine):
    """Area of the piston [m2]."""
    return 0.25 * pi * engine.bore * engine.bore


def swept_volume(engine):
    """Nominal swept volume, bore and stroke [m3]."""
    return piston_face(engine) * engine.stroke


def clearance_volume(engine):
    """Volume at the highest piston position: swept/(compression ratio - 1) [m3]."""
    return swept_volume(engine) / (engine.compression_ratio - 1.0)


class Crank(NamedTuple):
    """Slider and crank, as numbers for the kernels."""

    radius: float
    """[m]"""
    rod: float
    """[m]"""
    offset: float
    """[m]"""
    highest: float
    """Of the piston pin over the crank's axis [m]."""
    face: float
    """Area of the piston [m2]."""
    clearance: float
    """[m3]"""


def crank_of(engine):
    """Slider and crank of an engine.

    Parameters
    ----------
    engine : apesim.engine.cylinder.Engine

    Returns
    -------
    Crank
    """
    radius, rod, offset = 0.5 * engine.stroke, engine.rod_length, engine.pin_offset
    highest = sqrt((rod + radius) ** 2 - offset**2)
    return Crank(radius, rod, offset, highest, piston_face(engine), clearance_volume(engine))


@kernel
def cylinder_volume(crank, angle):
    """Volume of the cylinder and its slope.

    Parameters
    ----------
    crank : Crank
    angle : float
        Crank angle [rad].

    Returns
    -------
    volume : float
        [m3]
    slope : float
        [m3/rad]
    """
    s, c = crank.radius * sin(angle), crank.radius * cos(angle)
    aside = s - crank.offset
    along = sqrt(crank.rod * crank.rod - aside * aside)
    return (
        crank.clearance + crank.face * (crank.highest - c - along),
        crank.face * (s + aside * c / along),
    )
