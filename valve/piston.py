"""Piston of the valve: the forces on it, its two stops, and what dry friction does at rest.

Equations: the EPV paper (doi 10.1631/jzus.A0820373), Eqs. 1-2. The coordinate L runs from 0 (fully open) to the stroke
(closed); positive force and speed point to closed.
"""

from math import pi
from typing import Annotated, NamedTuple

from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.quantities.trees import Spelling
from apesim.valve.solenoid import Solenoid

HELD_CLOSED, TO_CLOSED, STUCK, TO_OPEN, HELD_OPEN = 2, 1, 0, -1, -2
"""Phases of the piston. The sign of a moving piston's phase is that of its speed."""
REST_SPEED = 1e-3
"""Slowest rebound that leaves a stop [m/s]; chosen, as slower ones would follow each other without end."""


class Valve(NamedTuple):
    """The electro-pneumatic valve (EPV): a piston between two chambers.

    Its dimensions, mass and springs are those of Table 1 of the EPV paper (doi 10.1631/jzus.A0820373), its viscous
    friction is the one identified there.
    """

    stroke: Annotated[float, Quantity("mm", 0.5, 100, "paper, Table 1 (L_max)")] = 9.0e-3
    moving_mass: Annotated[float, Quantity("kg", 0.0001, 10, "paper, Table 1 (M)")] = 0.1145
    piston_area: Annotated[float, Quantity("mm^2", 1, 100000, "paper, Table 1 (A); or give piston_diameter")] = (
        1134.1e-6
    )
    clearance_volume: Annotated[float, Quantity("mm^3", 10, 10000000, "paper, Table 1; each chamber")] = 11382e-9
    spring_rate: Annotated[float, Quantity("N/m", 0, 1000000, "paper, Table 1 (K), each spring")] = 1828.0
    viscous_friction: Annotated[float, Quantity("N s/m", 0, 10000, "paper, identified (beta)")] = 111.08
    solenoid: Solenoid = Solenoid()

    @staticmethod
    def spellings() -> dict[str, Spelling]:
        """Return the other ways to write a key of the valve: the piston's diameter d for its area, ``A = pi/4 d^2``.

        The equation is plain geometry.

        Returns
        -------
        dict of str to apesim.quantities.trees.Spelling
            By the name that is written.

        Examples
        --------
        >>> round(Valve.spellings()["piston_diameter"].convert(38e-3) * 1e6, 1)
        1134.1
        """
        diameter = Quantity("mm", 1.2, 350, "another spelling of piston_area", typical="38 mm")
        return {"piston_diameter": Spelling("piston_area", diameter, lambda d: 0.25 * pi * d * d)}


@kernel
def is_moving(phase: float) -> bool:
    """Return whether a phase of the piston is one of motion, TO_CLOSED or TO_OPEN."""
    return abs(phase) == TO_CLOSED


@kernel
def volume_a(valve: Valve, position: float) -> float:
    """Return the volume of chamber A, which pushes to closed: ``V_A = V_c + A L``.

    V_c is the clearance volume, A the piston's area, L its position: Table 1 and Fig. 1 of the EPV paper
    (doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    valve : Valve
        Dimensions of the valve.
    position : float
        Position L of the piston, 0 at fully open [m].

    Returns
    -------
    float
        Volume [m3].

    Examples
    --------
    At the default, 11 382 mm3 and 1134.1 mm2 times 9 mm:

    >>> round(volume_a(Valve(), 9e-3) * 1e9, 1)
    21588.9
    """
    return valve.clearance_volume + valve.piston_area * position


@kernel
def volume_b(valve: Valve, position: float) -> float:
    """Return the volume of chamber B, which pushes to open: ``V_B = V_c + A (L_max - L)``.

    V_c is the clearance volume, A the piston's area, L its position and L_max its stroke: Table 1 and Fig. 1 of the EPV
    paper (doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    valve : Valve
        Dimensions of the valve.
    position : float
        Position L of the piston, 0 at fully open [m].

    Returns
    -------
    float
        Volume [m3].

    Examples
    --------
    A closed valve leaves chamber B its clearance volume, 11 382 mm3 by default:

    >>> round(volume_b(Valve(), 9e-3) * 1e9, 1)
    11382.0
    """
    return valve.clearance_volume + valve.piston_area * (valve.stroke - position)


@kernel
def smooth_force(valve: Valve, position: float, speed: float, pressure_a: float, pressure_b: float) -> float:
    """Return the force of pressure, springs and viscous friction on the piston.

    ``F = (p_A - p_B) A + K (L_max - 2 L) - beta dL/dt``, Eq. 1 of the EPV paper [1]_ without dry friction.

    p_A and p_B are the chambers' pressures, A the piston's area, K the rate of each spring, L the piston's position,
    L_max its stroke and beta the coefficient of viscous friction.

    Parameters
    ----------
    valve : Valve
        Dimensions of the valve.
    position : float
        Position L of the piston, 0 at fully open [m].
    speed : float
        dL/dt, positive to closed [m/s].
    pressure_a, pressure_b : float
        Pressures of the chambers [Pa abs].

    Returns
    -------
    float
        Force, positive to closed [N].

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 1.

    Examples
    --------
    1134.1 mm2 times 0.1 MPa, less 111.08 N s/m times 1 m/s; at half the stroke the springs are in balance:

    >>> round(smooth_force(Valve(), 4.5e-3, 1.0, 3e5, 2e5), 3)
    2.33
    """
    return (
        (pressure_a - pressure_b) * valve.piston_area
        + valve.spring_rate * (valve.stroke - 2.0 * position)
        - valve.viscous_friction * speed
    )


@kernel
def dry_friction_force(phase: float, dry: float) -> float:
    """Return the dry friction on a moving piston, against its motion.

    ``F_f = -F_d sign(dL/dt)``, Eq. 2 of the EPV paper [1]_, which has it from Richer and Hurmuzlu [2]_. At rest
    friction is a reaction, and this is 0; see `overcome`.

    Parameters
    ----------
    phase : int
        Phase of the piston.
    dry : float
        Dry friction F_d without sign [N].

    Returns
    -------
    float
        Force, positive to closed [N].

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 2.
    .. [2] E. Richer and Y. Hurmuzlu, "A high performance pneumatic force actuator system: Part I - Nonlinear
       mathematical model", J. Dyn. Syst. Meas. Control 122, 2000, pp. 416-425.

    Examples
    --------
    >>> dry_friction_force(TO_CLOSED, 5.0), dry_friction_force(TO_OPEN, 5.0), dry_friction_force(STUCK, 5.0)
    (-5.0, 5.0, 0.0)
    """
    if phase == TO_CLOSED:
        return -dry
    if phase == TO_OPEN:
        return dry
    return 0.0


@kernel
def overcome(phase: float, force: float, breakaway: float) -> float:
    """Return by how much a force exceeds what holds the piston at rest; above zero the piston starts to move.

    A stop holds against any force towards it; breakaway friction holds against both directions.

    Friction at rest is a reaction of up to F_s, Eq. 2 of the EPV paper [1]_.

    Parameters
    ----------
    phase : int
        Phase of rest: HELD_CLOSED, STUCK or HELD_OPEN.
    force : float
        Force without dry friction, positive to closed [N].
    breakaway : float
        Largest dry friction at rest, without sign [N].

    Returns
    -------
    float
        Excess of the force [N].

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 2.

    Examples
    --------
    >>> overcome(HELD_CLOSED, -8.0, 5.0), overcome(HELD_CLOSED, 8.0, 5.0), overcome(STUCK, 8.0, 5.0)
    (3.0, -13.0, 3.0)
    """
    if phase == HELD_CLOSED:
        return -force - breakaway
    if phase == HELD_OPEN:
        return force - breakaway
    return abs(force) - breakaway


@kernel
def start_moving(phase: float, force: float) -> int:
    """Return the phase of a piston that a force sets in motion; from a stop there is one way only.

    `phase` is one of rest; of `force` [N], positive to closed, only the sign counts.
    """
    if phase == HELD_CLOSED:
        return TO_OPEN
    if phase == HELD_OPEN:
        return TO_CLOSED
    return TO_CLOSED if force > 0.0 else TO_OPEN


@kernel
def land(stop: int, speed: float, restitution: float) -> tuple[float, float]:
    """Return speed and phase of the piston after contact with a stop.

    ``v+ = -e v-``, Newton's law of restitution [1]_, with the coefficient e and the speeds v- before and v+ after
    contact. A rebound slower than `REST_SPEED` stays on the stop.

    Parameters
    ----------
    stop : int
        HELD_CLOSED or HELD_OPEN.
    speed : float
        Speed just before contact, positive to closed [m/s].
    restitution : float
        Speed after over speed before contact e, 0...1.

    Returns
    -------
    speed : float
        Speed after contact [m/s].
    phase : int
        Phase after contact.

    References
    ----------
    .. [1] W. J. Stronge, "Impact Mechanics", Cambridge University Press, 2000, doi 10.1017/CBO9780511626432.

    Examples
    --------
    >>> land(HELD_CLOSED, 2.0, 0.0) == (0.0, HELD_CLOSED), land(HELD_CLOSED, 2.0, 0.5) == (-1.0, TO_OPEN)
    (True, True)
    """
    rebound = -restitution * speed
    if abs(rebound) < REST_SPEED:
        return 0.0, stop
    return rebound, start_moving(stop, rebound)
