"""Flow function psi(r) of a restriction, over the ratio r of downstream to upstream pressure.

The law is that of isentropic flow of an ideal gas to the narrowest section: the EPV paper (doi 10.1631/jzus.A0820373),
Eq. 8.
"""

from math import exp, log, sqrt

from apesim.kernel import kernel

NEARLY_EQUAL = 0.999
"""Pressure ratio above which psi is taken as linear; chosen, as the slope of Eq. 8 is infinite at 1, where an adaptive
solver would chatter.
"""


@kernel
def critical_ratio(k: float) -> float:
    """Return the pressure ratio below which the flow is choked.

    ``b = (2/(k + 1))^(k/(k - 1))``, Eq. 8 of the EPV paper.

    The gas is ideal and flows without loss or heat to the narrowest section [1]_.

    Parameters
    ----------
    k : float
        Ratio of the heat capacities, above 1.

    Returns
    -------
    float
        Critical pressure ratio.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 8.

    Examples
    --------
    >>> round(critical_ratio(1.4), 4)
    0.5283
    """
    return (2.0 / (k + 1.0)) ** (k / (k - 1.0))


@kernel
def choked_flow_function(k: float) -> float:
    """Return the flow function of choked flow.

    ``psi = (2/(k + 1))^(1/(k - 1)) sqrt(2 k/(k + 1))``, Eq. 8 of the EPV paper.

    The gas is ideal and flows without loss or heat to the narrowest section [1]_.

    Parameters
    ----------
    k : float
        Ratio of the heat capacities, above 1.

    Returns
    -------
    float
        psi below the critical pressure ratio.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 8, second line.

    Examples
    --------
    >>> round(choked_flow_function(1.4), 4)
    0.6847
    """
    return (2.0 / (k + 1.0)) ** (1.0 / (k - 1.0)) * sqrt(2.0 * k / (k + 1.0))


@kernel
def subsonic_flow_function(ratio: float, k: float) -> float:
    """Return the flow function of flow that is not choked.

    ``psi = sqrt(2 k/(k - 1) (r^(2/k) - r^((k + 1)/k)))``, Eq. 8 of the EPV paper; computed with one power, a = r^(1/k).

    The gas is ideal and flows without loss or heat to the narrowest section [1]_. Below the critical ratio the flow is
    choked, and this branch does not hold.

    Parameters
    ----------
    ratio : float
        Downstream over upstream pressure, from the critical ratio to 1.
    k : float
        Ratio of the heat capacities, above 1.

    Returns
    -------
    float
        psi; 0 at equal pressures.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 8, first line.

    Examples
    --------
    >>> round(subsonic_flow_function(0.8, 1.4), 4)
    0.5607
    """
    a = exp(log(ratio) / k)
    return sqrt(2.0 * k / (k - 1.0) * a * (a - ratio))


@kernel
def subsonic_slope(ratio: float, k: float) -> float:
    """Return the slope of the flow function over the pressure ratio where the flow is not choked.

    It is d(psi)/dr of Eq. 8 of the EPV paper, and negative: less flows as the pressures come closer.

    The derivative [1]_ holds where the flow is not choked.

    Parameters
    ----------
    ratio : float
        Downstream over upstream pressure, from the critical ratio to below 1.
    k : float
        Ratio of the heat capacities, above 1.

    Returns
    -------
    float
        Slope of psi.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 8, first line.

    Examples
    --------
    >>> round(subsonic_slope(0.8, 1.4), 3)
    -1.02
    >>> round((subsonic_flow_function(0.801, 1.4) - subsonic_flow_function(0.799, 1.4)) / 0.002, 3)
    -1.02
    """
    a = exp(log(ratio) / k)
    return 0.5 * subsonic_flow_function(ratio, k) * ((2.0 * a / ratio - 1.0) / k - 1.0) / (a - ratio)
