"""Where engine air and control air come from."""

from math import isnan
from typing import Annotated, NamedTuple

from apesim.quantities import Choice, Pressure, Quantity

REGULATOR, RECEIVER = 0, 1


class Supply(NamedTuple):
    """Compressed air behind its regulator."""

    pressure: Annotated[float, Pressure(0.02, 30, "chosen: 1.0 MPa gauge", show="gauge")] = 1.101325e6
    temperature: Annotated[float, Quantity("K", 150, 600, "paper, Table 1 (T_0)")] = 287.0
    control_air: Annotated[
        int, Choice(("regulator", "receiver"), "chosen; receiver: its pressure acts back on the valve")
    ] = REGULATOR
    control_pressure: Annotated[
        float, Pressure(0.02, 30, "of control air from the regulator", show="gauge", text="the supply's", optional=True)
    ] = float("nan")

    def control(self):
        """Pressure [Pa abs] and temperature [K] of control air from the regulator."""
        pressure = self.pressure if isnan(self.control_pressure) else self.control_pressure
        return pressure, self.temperature
