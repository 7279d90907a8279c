"""Cylinder of the engine: its keys in a machine file, and its gas, one zone with balances of mass and energy."""

from collections.abc import Callable, Iterator
from typing import Annotated, Any, NamedTuple

import numpy as np

from apesim.air import Gas, GasState
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cam import Cam
from apesim.engine.exhaust import AnyExhaust, Exhaust, SecondExhaust
from apesim.engine.friction import Friction
from apesim.engine.receiver import Receiver
from apesim.kernel import kernel
from apesim.quantities import NO_LIST, Choice, Quantity, QuantityList

EPV, CAM, IDEAL_VALVE = 0, 1, 2
INTAKES = ("epv", "cam", "ideal")
"""Kinds of intake, as a machine file names them: electro-pneumatic valve, cam, ideal valve."""


MAX_CYLINDERS = 8
"""Most cylinders of an engine: more are several engines on one shaft, and each costs a march."""


def crank_faults(sizes: Any) -> Iterator[tuple[str, str, str]]:
    """Find whether a crank of some ``stroke``, ``rod_length`` and ``pin_offset`` [m] cannot turn: key, wrong, right."""
    shortest = 0.5 * sizes.stroke + abs(sizes.pin_offset)
    if sizes.rod_length <= shortest:
        right = f"more than half the stroke plus the pin offset, {shortest * 1e3:g} mm"
        yield "rod_length", "the crank cannot turn", right


class Engine(NamedTuple):
    """Engine, two-stroke: one intake event a revolution in each of its cylinders, which are alike unless given."""

    bore: Annotated[float, Quantity("mm", 5, 1000, "chosen")] = 85.0e-3
    stroke: Annotated[float, Quantity("mm", 5, 2000, "chosen")] = 88.0e-3
    rod_length: Annotated[float, Quantity("mm", 5, 5000, "chosen")] = 150.0e-3
    pin_offset: Annotated[
        float, Quantity("mm", -100, 100, "chosen; positive to the side to which the crank pin moves after 0 deg")
    ] = 0.0
    compression_ratio: Annotated[float, Quantity("", 1.5, 100, "chosen; (swept + clearance)/clearance")] = 18.0
    intake: Annotated[int, Choice(INTAKES, "chosen; ideal: full groove area between the targets, at once")] = EPV
    cylinders: Annotated[
        float, Quantity("", 1, MAX_CYLINDERS, "chosen; how many, on one receiver and one shaft", whole=True)
    ] = 1.0
    phases: Annotated[
        np.ndarray,
        QuantityList(
            Quantity("deg", 0, 360, "chosen"),
            MAX_CYLINDERS,
            "chosen; the shaft's angle at angle 0 of each cylinder",
            text="evenly spread over a turn",
        ),
    ] = NO_LIST
    cam: Cam = Cam()
    exhaust: Exhaust = Exhaust()
    exhaust_2: SecondExhaust = SecondExhaust()
    receiver: Receiver = Receiver()
    friction: Friction = Friction()

    @property
    def exhausts(self) -> tuple[Exhaust, ...]:
        """The exhaust valves that the engine has."""
        return (self.exhaust, Exhaust(*self.exhaust_2)) if self.exhaust_2.is_on else (self.exhaust,)

    def replace_exhausts(self, change: Callable[[AnyExhaust], Any]) -> "Engine":
        """Return the engine with each of its exhaust valves changed."""
        return self._replace(exhaust=change(self.exhaust), exhaust_2=change(self.exhaust_2))

    def resolve_phases(self) -> np.ndarray:
        """Return the angle of the shaft [rad] at angle 0 of each cylinder, (n,); evenly spread where not given.

        >>> np.degrees(Engine(cylinders=3.0).resolve_phases()).round(9).tolist()
        [0.0, 120.0, 240.0]
        """
        return self.phases if len(self.phases) else TURN * np.arange(self.cylinders) / self.cylinders

    def faults(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the engine, beyond the ranges of single keys: key, wrong, right."""
        yield from self._faults_of_phases()
        yield from crank_faults(self)

    def _faults_of_phases(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the phases: key, wrong, right."""
        count = len(self.phases)
        if count and count != self.cylinders:
            engine = f"{self.cylinders:g} cylinder{'s' * (self.cylinders > 1.0)}"
            wrong = f"{count} {'angles are' if count > 1 else 'angle is'} given for {engine}"
            yield "phases", wrong, "give one for each cylinder, or none: they are evenly spread then"
        if count and self.phases.max() >= TURN:
            yield "phases", f"{self.phases.max() / DEGREE:g} deg is a whole turn", "at least 0 and less than 360 deg"


Engine.due = {"exhaust_2": ("effective_area",)}  # type: ignore[attr-defined]

MASS = 0
"""Term of the cylinder's balance: mass from outside [kg/s]."""
ENERGY = 1
"""Term of the cylinder's balance: energy from outside [W]."""
GROOVE_MASS = 2
"""Term of the cylinder's balance: mass past the groove [kg/s]."""
GROOVE_ENERGY = 3
"""Term of the cylinder's balance: energy past the groove [W]."""
HEAT = 4
"""Term of the cylinder's balance: the part of ENERGY that is heat [W]."""
WALL_EXERGY = 5
"""Term of the cylinder's balance: exergy of the heat at the temperature of the wall that it comes from [W]."""
BRANCH = 6
"""Term of the cylinder's balance: branches of the laws, see `apesim.effect.note_branch`."""
TERM_NAMES = "MASS", "ENERGY", "GROOVE_MASS", "GROOVE_ENERGY", "HEAT", "WALL_EXERGY", "BRANCH"
"""Names of the terms of the cylinder's balance, for messages."""
TERMS = len(TERM_NAMES)
"""Length of the cylinder's balance."""


class CylinderState(NamedTuple):
    """State of the cylinder at an instant, as the laws of its effects see it."""

    gas: Gas
    """Working gas."""
    ambient: GasState
    """State of the surroundings."""
    engine: Engine
    """Keys of the engine."""
    speed: float
    """Speed of the crank [rad/s]."""
    angle: float
    """Crank angle [rad]."""
    volume: float
    """Volume of the cylinder [m3]."""
    air: GasState
    """State of the air in the cylinder."""
    intake: GasState
    """State of the air before the groove."""
    behind_exhaust: GasState
    """State of the air behind the exhaust valves."""


@kernel
def indicated_power(pressure: float, ambient_pressure: float, slope: float, speed: float) -> float:
    """Indicated power of the cylinder at an instant, ``P = (p - p_0) dV/dphi omega``.

    At a speed of 1 rad/s it is the indicated torque [N m].

    Its integral over a cycle is the indicated work of p dV [1]_, as that of the constant p_0 dV is zero. p and p_0 are
    the pressures in the cylinder and of the ambient, V the volume, phi the crank angle and omega the speed.

    Parameters
    ----------
    pressure : float
        Pressure p in the cylinder [Pa abs].
    ambient_pressure : float
        Pressure p_0 on the other side of the piston [Pa abs].
    slope : float
        Slope dV/dphi of the cylinder's volume over the crank angle [m3/rad].
    speed : float
        Speed omega of the crank [rad/s].

    Returns
    -------
    float
        Indicated power [W].

    References
    ----------
    .. [1] J. B. Heywood, "Internal Combustion Engine Fundamentals", McGraw-Hill, 1988, Eqs. 2.14 and 2.15.

    Examples
    --------
    1 MPa above ambient, 0.2 L/rad and 100 rad/s make 20 kW:

    >>> round(indicated_power(1.1e6, 0.1e6, 0.2e-3, 100.0), 6)
    20000.0
    """
    return (pressure - ambient_pressure) * slope * speed
