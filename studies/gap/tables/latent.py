"""The quantity that a table stands for, against what it was made to depend on."""

from typing import NamedTuple

import numpy as np

from apesim.cubic_table import interpolate_clamped, interpolate_periodic

SEEN = 0.01
"""Share of its range from which a branch of a table counts as moved."""
POINTS = 121
"""Number of points of a curve."""
ROUND = "tabulated_cylinder_heat", "tabulated_cylinder_leak"
"""Tables over the crank angle."""
STRAIGHT = "tabulated_delay", "tabulated_groove"
"""Tables that are linear between their nodes; the others are cubic."""
OVER = {
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
"""What the places of a table are, or of one of its branches."""
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
    "tabulated_cylinder_heat.share": "heat over p V ω",
    "tabulated_cylinder_leak.out": "leak of the cylinder",
    "tabulated_cylinder_leak.past_groove": "leak past the groove",
    "tabulated_groove.share": "more area of the groove",
}
"""What the values of a branch are."""


class Branch(NamedTuple):
    """One quantity over the nodes of a table."""

    table: str
    """Name of the effect."""
    name: str
    places: np.ndarray
    """(n,), in the unit of `over`."""
    values: np.ndarray
    """(n,), in `unit`."""
    deviations: np.ndarray
    """Standard deviations of the values, (n,)."""
    unit: str

    @property
    def is_round(self):
        """Whether the places are those of a turn."""
        return self.table in ROUND

    @property
    def over(self):
        """What the places are, with their unit."""
        return OVER.get(f"{self.table}.{self.name}", OVER[self.table])

    @property
    def quantity(self):
        """What the values are, with their unit."""
        return f"{QUANTITIES[f'{self.table}.{self.name}']}{f' [{self.unit}]' if self.unit else ''}"

    def curve(self):
        """Places and values between the nodes, as the march has them; (m,) and (m,) float array."""
        last, values = len(self.places) - 1, tuple(map(float, self.values))
        if self.is_round:
            at = np.linspace(0.0, last + 1.0, POINTS)
            places = np.append(self.places, 360.0)
            return np.interp(at, np.arange(last + 2), places), np.array([interpolate_periodic(values, p) for p in at])
        at = np.linspace(0.0, last, POINTS)
        if self.table in STRAIGHT or not last:
            found = np.interp(at, np.arange(last + 1), values)
        else:
            found = np.array([interpolate_clamped(values, place) for place in at])
        return np.interp(at, np.arange(last + 1), self.places), found


def branches(model):
    """The branches of a fitted table that moved.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model
        With the table as its last candidate.

    Returns
    -------
    list of Branch
    """
    candidate = model.candidates[-1]
    effect = getattr(model.machine().effects, candidate.name)
    spread = np.sqrt(np.diag(model.fitted.covariance))[-len(candidate.strengths) :]
    rows: dict = {}
    for parameter, deviation in zip(candidate.strengths, spread, strict=True):
        field = parameter.key.split(".")[-1]
        branch, place = field.rsplit("_at_", 1)
        value, most = getattr(effect, field), abs(parameter.scale)
        numbers = (
            float(place.replace("minus_", "-")),
            *(parameter.shown(v) for v in (value, deviation * most, most)),
        )
        rows.setdefault(branch, []).append((*numbers, parameter.declaration.unit))
    found = []
    for name, own in rows.items():
        places, values, deviations, most = np.array([row[:4] for row in own]).T
        if np.abs(values).max() >= SEEN * most.max():
            found.append(Branch(candidate.name, name, places, values, deviations, own[0][4]))
    return found
