"""The flow function psi(r) of a restriction (Eq. 8), over the ratio of downstream to upstream pressure."""

from math import exp, log, sqrt

from apesim.kernel import kernel

NEARLY_EQUAL = 0.999
"""Pressure ratio above which psi is taken as linear: Eq. 8 has an infinite slope at 1."""


@kernel
def critical_ratio(k):
    """Pressure ratio below which the flow is choked (Eq. 8)."""
    return (2.0 / (k + 1.0)) ** (k / (k - 1.0))


@kernel
def choked_flow_function(k):
    """psi of choked flow (Eq. 8)."""
    return (2.0 / (k + 1.0)) ** (1.0 / (k - 1.0)) * sqrt(2.0 * k / (k + 1.0))


@kernel
def subsonic_flow_function(ratio, k):
    """psi of flow that is not choked (Eq. 8), written with one power: a = r^(1/k)."""
    a = exp(log(ratio) / k)
    return sqrt(2.0 * k / (k - 1.0) * a * (a - ratio))


@kernel
def subsonic_slope(ratio, k):
    """Slope of psi over the pressure ratio where the flow is not choked."""
    a = exp(log(ratio) / k)
    return 0.5 * subsonic_flow_function(ratio, k) * ((2.0 * a / ratio - 1.0) / k - 1.0) / (a - ratio)
