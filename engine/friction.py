"""Mechanical friction of the engine, as a mean effective pressure."""

from math import pi
from typing import Annotated, NamedTuple

from apesim.kernel import kernel
from apesim.quantities import Quantity


class Friction(NamedTuple):
    """Constants of Chen and Flynn's friction mean effective pressure.

    The correlation is that of Chen and Flynn [1]_; its constants vary from engine to engine.

    References
    ----------
    .. [1] S. K. Chen and P. F. Flynn, "Development of a single cylinder compression ignition research engine",
       SAE 650733, 1965, doi 10.4271/650733.
    """

    constant: Annotated[float, Quantity("bar", 0, 10, "Chen and Flynn, SAE 650733; constants vary")] = 0.4e5
    peak_pressure: Annotated[float, Quantity("", 0, 0.1, "Chen and Flynn; times the peak cylinder pressure")] = 0.005
    piston_speed: Annotated[float, Quantity("bar s/m", 0, 2, "Chen and Flynn; times the mean piston speed")] = 0.08e5
    piston_speed_squared: Annotated[float, Quantity("bar s^2/m^2", 0, 0.1, "Chen and Flynn")] = 0.0008e5


@kernel
def friction_mean_effective_pressure(friction: Friction, peak_pressure: float, piston_speed: float) -> float:
    """Friction mean effective pressure of a cycle by Chen and Flynn's correlation.

    ``fmep = A + B p_max + C S_p + D S_p^2`` [1]_, with the peak cylinder pressure p_max and the mean piston speed S_p.
    The constants A to D vary from engine to engine.

    Parameters
    ----------
    friction : Friction
        Constants A [Pa], B, C [Pa s/m] and D [Pa s2/m2].
    peak_pressure : float
        Highest cylinder pressure of the cycle [Pa abs].
    piston_speed : float
        Mean piston speed [m/s].

    Returns
    -------
    float
        Friction mean effective pressure [Pa].

    References
    ----------
    .. [1] S. K. Chen and P. F. Flynn, "Development of a single cylinder compression ignition research engine",
       SAE 650733, 1965, doi 10.4271/650733.

    Examples
    --------
    At 10 bar and 3 m/s: 0.4 + 0.005 * 10 + 0.08 * 3 + 0.0008 * 9 = 0.6972 bar.

    >>> round(friction_mean_effective_pressure(Friction(), 10e5, 3.0), 6)
    69720.0
    """
    return (
        friction.constant
        + friction.peak_pressure * peak_pressure
        + friction.piston_speed * piston_speed
        + friction.piston_speed_squared * piston_speed**2
    )


@kernel
def mean_piston_speed(stroke: float, speed: float) -> float:
    """Mean speed of the piston, two strokes a turn: ``S_p = H omega/pi`` with the stroke H and the speed omega.

    It is ``2 L N`` with stroke and revolutions per second [1]_.

    Parameters
    ----------
    stroke : float
        Stroke of the piston [m].
    speed : float
        Speed of the crank [rad/s].

    Returns
    -------
    float
        Mean piston speed [m/s].

    References
    ----------
    .. [1] J. B. Heywood, "Internal Combustion Engine Fundamentals", McGraw-Hill, 1988, Eq. 2.9.

    Examples
    --------
    A stroke of 0.1 m at 1500 r/min, 25 turns a second, makes 5 m/s:

    >>> from math import pi
    >>> round(mean_piston_speed(0.1, 50.0 * pi), 9)
    5.0
    """
    return stroke * speed / pi
