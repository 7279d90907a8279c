"""Supply of engine air and control air."""

from math import isnan
from typing import Annotated, NamedTuple

from apesim.air import GasState
from apesim.quantities import Choice, Pressure, Quantity

REGULATOR, RECEIVER = 0, 1
"""Sources of the control air."""


class Supply(NamedTuple):
    """Compressed air behind its regulator.

    The temperature is T_0 of Table 1 of the EPV paper (doi 10.1631/jzus.A0820373).
    """

    pressure: Annotated[float, Pressure(0.02, 30, "chosen: 1.0 MPa gauge", show="gauge")] = 1.101325e6
    temperature: Annotated[float, Quantity("K", 150, 600, "paper, Table 1 (T_0)")] = 287.0
    control_air: Annotated[
        int, Choice(("regulator", "receiver"), "chosen; receiver: its pressure acts back on the valve")
    ] = REGULATOR
    control_pressure: Annotated[
        float, Pressure(0.02, 30, "of control air from the regulator", show="gauge", text="the supply's", optional=True)
    ] = float("nan")

    def engine_air(self) -> GasState:
        """Return the state of the engine air before the receiver: pressure and temperature of the supply."""
        return GasState(float(self.pressure), self.temperature)

    def control(self) -> GasState:
        """Return the state of control air from the regulator.

        It has the control pressure, or the supply's where none is given, and the temperature of the supply.
        """
        pressure = self.pressure if isnan(self.control_pressure) else self.control_pressure
        return GasState(float(pressure), self.temperature)


class ValveSupply(NamedTuple):
    """Air that is fed to the valve at an instant."""

    control: GasState
    """State of the control air before the solenoids."""
    intake_pressure: float
    """Pressure of the air before the groove [Pa abs]."""
