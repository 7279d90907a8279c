"""Supply of engine air and control air."""

from math import isnan
from typing import Annotated, NamedTuple

from apesim.quantities import Choice, Pressure, Quantity

REGULATOR, RECEIVER = 0, 1
"""Sources of the control air."""


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

    def control(self) -> tuple[float, float]:
        """Return the state of control air from the regulator.

        Returns
        -------
        pressure : float
            Control pressure, or the supply's where none is given [Pa abs].
        temperature : float
            Temperature of the supply [K].

        Examples
        --------
        >>> Supply(pressure=1e6, temperature=290.0).control()
        (1000000.0, 290.0)
        """
        pressure = self.pressure if isnan(self.control_pressure) else self.control_pressure
        return pressure, self.temperature
