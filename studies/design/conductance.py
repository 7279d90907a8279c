"""Solenoid valves by ISO 6358: the effective area that stands for a sonic conductance and a critical pressure ratio."""

import numpy as np

from apesim.air import Air, gas_of
from apesim.restriction import AREA_OF_CONDUCTANCE, flow_function

POINTS = 400
"""Points of the mean over the pressure ratio: the area moves by less than 1e-4 with twice as many."""
FILLED = 0.95
"""Pressure ratio up to which a chamber counts as filled; chosen: by then the piston has crossed."""
REFERENCE = 293.15
"""Temperature of the reference atmosphere of ISO 8778 [K]."""


def effective_area_of(conductance: float, critical: float, lowest: float) -> float:
    """Return the effective area [m2] that fills a chamber in the time that a valve of ISO 6358 needs.

    ``S = 5.02 mm2/(dm3/(s bar)) C integral(dr/psi_S)/integral(dr/psi_C)``: the first factor is the same choked flow,
    and psi are the flow functions of Eq. 8 and of ISO 6358-1:2013, each over its choked value. The integrals are times
    to fill a volume at constant temperature, from the pressure ratio `lowest` to 0.95. That the filling time
    is what has to agree is chosen: with b below 0.528 a valve of the same choked flow fills more slowly than Eq. 8 has
    it.

    `conductance` C is in [m3/(s Pa)], `critical` is b.

    >>> round(effective_area_of(2e-8, 0.3, 0.1) * 1e6, 2), round(effective_area_of(2e-8, 0.528, 0.1) * 1e6, 2)
    (9.22, 10.03)
    """
    gas = gas_of(Air())
    ratios = lowest + (FILLED - lowest) * (np.arange(POINTS) + 0.5) / POINTS
    choked = flow_function(gas, 0.0, REFERENCE)
    by_area = np.mean([choked / flow_function(gas, ratio, REFERENCE) for ratio in ratios])
    share = np.maximum(ratios - critical, 0.0) / (1.0 - critical)
    by_conductance = np.mean(1.0 / np.sqrt(1.0 - share**2))
    return float(AREA_OF_CONDUCTANCE * conductance * by_area / by_conductance)
