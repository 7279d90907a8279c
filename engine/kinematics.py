"""Kinematics of the slider-crank: volume of the cylinder over the crank angle, with a pin offset.

At crank angle 0 the crank pin is up; without an offset this is top dead centre (TDC). The offset is positive towards
the side to which the crank pin moves after angle 0.
"""

from math import cos, pi, sin, sqrt
from typing import NamedTuple

from apesim.engine.cylinder import Engine
from apesim.kernel import kernel


@kernel
def piston_face(engine: Engine) -> float:
    """Area of the engine's piston, ``A_p = pi/4 B^2`` with the bore B.

    It is plain geometry.

    Parameters
    ----------
    engine : apesim.engine.cylinder.Engine
        Dimensions of the engine; the bore [m] is used.

    Returns
    -------
    float
        Area of the piston [m2].

    Examples
    --------
    >>> from apesim.engine.cylinder import Engine
    >>> round(piston_face(Engine(bore=0.1)), 6)
    0.007854
    """
    return 0.25 * pi * engine.bore * engine.bore


@kernel
def swept_volume(engine: Engine) -> float:
    """Nominal swept volume of the cylinder, ``V_s = A_p H`` with the piston's area A_p and the stroke H.

    With a pin offset the piston travels a little more than the nominal stroke; the nominal volume does not change.

    It is defined as for other piston engines [1]_.

    Parameters
    ----------
    engine : apesim.engine.cylinder.Engine
        Dimensions of the engine; bore and stroke [m] are used.

    Returns
    -------
    float
        Nominal swept volume [m3].

    References
    ----------
    .. [1] J. B. Heywood, "Internal Combustion Engine Fundamentals", McGraw-Hill, 1988, section 2.2.

    Examples
    --------
    >>> from apesim.engine.cylinder import Engine
    >>> round(swept_volume(Engine(bore=0.1, stroke=0.1)) * 1e6, 1)
    785.4
    """
    return piston_face(engine) * engine.stroke


def clearance_volume(engine: Engine) -> float:
    """Clearance volume, ``V_c = V_s/(epsilon - 1)`` with the swept volume V_s and the compression ratio epsilon.

    It is the volume of the cylinder at the highest position of the piston, also with a pin offset.

    The compression ratio is (V_s + V_c)/V_c [1]_.

    Parameters
    ----------
    engine : apesim.engine.cylinder.Engine
        Dimensions of the engine; bore, stroke [m] and compression ratio are used.

    Returns
    -------
    float
        Clearance volume [m3].

    References
    ----------
    .. [1] J. B. Heywood, "Internal Combustion Engine Fundamentals", McGraw-Hill, 1988, Eq. 2.1.

    Examples
    --------
    A swept volume of 785.4 cm3 and a compression ratio of 11 leave a tenth of it:

    >>> from apesim.engine.cylinder import Engine
    >>> round(clearance_volume(Engine(bore=0.1, stroke=0.1, compression_ratio=11.0)) * 1e6, 2)
    78.54
    """
    return swept_volume(engine) / (engine.compression_ratio - 1.0)


class Crank(NamedTuple):
    """Dimensions of the slider-crank, as the kernels take them."""

    radius: float
    """Radius of the crank, half the stroke [m]."""
    rod: float
    """Length of the connecting rod [m]."""
    offset: float
    """Offset of the piston pin from the crank's axis [m]."""
    highest: float
    """Highest position of the piston pin above the crank's axis [m]."""
    face: float
    """Area of the piston [m2]."""
    clearance: float
    """Clearance volume [m3]."""


def crank_of(engine: Engine) -> Crank:
    """Compute the dimensions of an engine's slider-crank.

    The piston pin is highest where crank and rod are in line: ``h = sqrt((l + r)^2 - e^2)``, with the crank's
    radius r, the rod's length l and the pin offset e.

    It is plain geometry.

    Parameters
    ----------
    engine : apesim.engine.cylinder.Engine
        Dimensions of the engine. The rod has to be longer than radius plus offset, or the crank cannot turn; a
        machine file with a shorter one is refused.

    Returns
    -------
    Crank
        Dimensions for `cylinder_volume`.

    Raises
    ------
    ValueError
        If the pin offset is larger than the crank's radius and the rod's length together.

    Examples
    --------
    >>> from apesim.engine.cylinder import Engine
    >>> crank = crank_of(Engine(stroke=0.08, rod_length=0.12))
    >>> round(crank.radius, 6), round(crank.highest, 6)
    (0.04, 0.16)
    """
    radius, rod, offset = 0.5 * engine.stroke, engine.rod_length, engine.pin_offset
    highest = sqrt((rod + radius) ** 2 - offset**2)
    return Crank(radius, rod, offset, highest, piston_face(engine), clearance_volume(engine))


@kernel
def cylinder_volume(crank: Crank, angle: float) -> tuple[float, float]:
    """Volume of the cylinder at a crank angle, and its slope over the angle.

    ``V = V_c + A_p (h - r cos(phi) - sqrt(l^2 - (r sin(phi) - e)^2))``, with the clearance volume V_c, the piston's
    area A_p, the highest position h of the piston pin, the crank's radius r, the rod's length l, the pin offset e and
    the crank angle phi. The equation is the geometry of the slider-crank; it is exact at every angle. Without an offset
    it is the usual one [1]_.

    Parameters
    ----------
    crank : Crank
        Dimensions of the slider-crank.
    angle : float
        Crank angle [rad].

    Returns
    -------
    volume : float
        Volume of the cylinder [m3].
    slope : float
        Slope dV/dphi [m3/rad].

    References
    ----------
    .. [1] J. B. Heywood, "Internal Combustion Engine Fundamentals", McGraw-Hill, 1988, Eqs. 2.4 and 2.5.

    Examples
    --------
    A quarter of a turn after TDC, with r = 3, l = 5, no offset, a piston of 1 m2 and no clearance, the pin is 4 m
    above the axis, and so 4 m below its highest position:

    >>> from math import pi
    >>> volume, slope = cylinder_volume(Crank(3.0, 5.0, 0.0, 8.0, 1.0, 0.0), 0.5 * pi)
    >>> round(volume, 9), round(slope, 9)
    (4.0, 3.0)
    """
    s, c = crank.radius * sin(angle), crank.radius * cos(angle)
    sideways = s - crank.offset
    along = sqrt(crank.rod * crank.rod - sideways * sideways)
    return (
        crank.clearance + crank.face * (crank.highest - c - along),
        crank.face * (s + sideways * c / along),
    )


@kernel
def volume_curvature(crank: Crank, angle: float) -> float:
    """Curvature d2V/dphi2 of the cylinder's volume over the crank angle [m3/rad2], from `cylinder_volume` by geometry.

    At TDC without an offset it is A_p r (1 + r/l):

    >>> round(volume_curvature(Crank(3.0, 5.0, 0.0, 8.0, 1.0, 0.0), 0.0), 9)
    4.8
    """
    s, c = crank.radius * sin(angle), crank.radius * cos(angle)
    sideways = s - crank.offset
    along = sqrt(crank.rod * crank.rod - sideways * sideways)
    return crank.face * (c + (c * c - sideways * s) / along + (sideways * c) ** 2 / along**3)
