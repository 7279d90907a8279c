"""The quantity that a table stands for, against what it was made to depend on."""

from typing import NamedTuple

import numpy as np

from apesim.cubic_table import interpolate_clamped, interpolate_periodic
from apesim.studies.estimation.model import Model

MIN_MOVED = 0.01
"""Share of its range from which a branch of a table counts as moved: less would not be seen in a figure."""
CURVE_POINTS = 121
"""Number of points of a curve."""
PERIODIC = "tabulated_cylinder_heat", "tabulated_cylinder_leak"
"""Tables over the crank angle."""
LINEAR = "tabulated_delay", "tabulated_groove"
"""Tables that are linear between their nodes; the others are cubic."""
ABSCISSAE = {
    "tabulated_force": "lift over the stroke [%]",
    "tabulated_damping": "speed [mm/s]",
    "tabulated_damping.seal": "both chambers above ambient [kPa]",
    "tabulated_heat": "air above ambient [K]",
    "tabulated_leak": "lift over the stroke [%]",
    "tabulated_area": "lower over higher pressure [%]",
    "tabulated_delay": "opening of the solenoid [%]",
    "tabulated_delay.pressure": "control pressure above ambient [kPa]",
    "tabulated_cylinder_heat": "crank angle [deg]",
    "tabulated_cylinder_leak": "crank angle [deg]",
    "tabulated_groove": "travel from the lap on [%]",
}
"""Quantity over which a table stands, or one of its branches."""
QUANTITIES = {
    "tabulated_force.force": "force to closed",
    "tabulated_force.friction": "force against the motion",
    "tabulated_damping.friction": "force against the motion",
    "tabulated_damping.seal": "seals' force against the motion",
    "tabulated_heat.a": "heat into chamber A",
    "tabulated_heat.b": "heat into chamber B",
    "tabulated_leak.a": "leak of chamber A",
    "tabulated_leak.b": "leak of chamber B",
    "tabulated_leak.between": "leak from A to B",
    "tabulated_area.filling": "more area, filling",
    "tabulated_area.venting": "more area, venting",
    "tabulated_delay.a": "solenoid A later by",
    "tabulated_delay.b": "solenoid B later by",
    "tabulated_delay.pressure": "both later by",
    "tabulated_cylinder_heat.share": "heat over p V ω [-]",
    "tabulated_cylinder_leak.out": "leak of the cylinder",
    "tabulated_cylinder_leak.past_groove": "leak past the groove",
    "tabulated_groove.share": "more area of the groove",
}
"""Quantity that a branch of a table stands for."""


class Branch(NamedTuple):
    """One quantity over the nodes of a table."""

    table: str
    """Name of the effect."""
    name: str
    """Name of the branch."""
    positions: np.ndarray
    """Positions of the nodes, (n,), in the unit of `abscissa`."""
    values: np.ndarray
    """Values at the nodes, (n,), in `unit`."""
    standard_deviations: np.ndarray
    """Standard deviations of the values, (n,)."""
    unit: str
    """Unit of the values, as in the machine file."""

    @property
    def is_periodic(self) -> bool:
        """Whether the nodes stand over a turn of the crank."""
        return self.table in PERIODIC

    @property
    def abscissa(self) -> str:
        """Quantity over which the nodes stand, with its unit."""
        return ABSCISSAE.get(f"{self.table}.{self.name}", ABSCISSAE[self.table])

    @property
    def quantity(self) -> str:
        """Quantity that the values are of, with its unit."""
        return f"{QUANTITIES[f'{self.table}.{self.name}']}{f' [{self.unit}]' if self.unit else ''}"

    def interpolate(self) -> tuple[np.ndarray, np.ndarray]:
        """Interpolate between the nodes, as the march does.

        The arrays (m,) are positions, in the unit of `abscissa`, and values, in `unit`.
        """
        last, values = len(self.positions) - 1, tuple(map(float, self.values))
        if self.is_periodic:
            at = np.linspace(0.0, last + 1.0, CURVE_POINTS)
            ends = np.append(self.positions, 360.0)
            return np.interp(at, np.arange(last + 2), ends), np.array([interpolate_periodic(values, p) for p in at])
        at = np.linspace(0.0, last, CURVE_POINTS)
        if self.table in LINEAR or not last:
            curve = np.interp(at, np.arange(last + 1), values)
        else:
            curve = np.array([interpolate_clamped(values, p) for p in at])
        return np.interp(at, np.arange(last + 1), self.positions), curve


def find_branches(model: Model) -> list[Branch]:
    """Find the branches of a fitted table that moved; the table is the last candidate of `model`."""
    candidate = model.candidates[-1]
    effect = getattr(model.machine().effects, candidate.name)
    spread = np.sqrt(np.diag(model.fitted.covariance))[-len(candidate.strengths) :]
    rows: dict[str, list[tuple[float, ...]]] = {}
    units: dict[str, str] = {}
    for parameter, deviation in zip(candidate.strengths, spread, strict=True):
        field = parameter.key.split(".")[-1]
        branch, position = field.rsplit("_at_", 1)
        value, scale = getattr(effect, field), abs(parameter.scale)
        shown = (parameter.shown(v) for v in (value, deviation * scale, scale))
        rows.setdefault(branch, []).append((float(position.replace("minus_", "-")), *shown))
        units[branch] = parameter.declaration.unit  # type: ignore[attr-defined]
    branches = []
    for name, nodes in rows.items():
        positions, values, standard_deviations, scales = np.array(nodes).T
        if np.abs(values).max() >= MIN_MOVED * scales.max():
            branches.append(Branch(candidate.name, name, positions, values, standard_deviations, units[name]))
    return branches
