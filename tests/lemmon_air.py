"""Ideal-gas air of Lemmon, Jacobsen, Penoncello and Friend (2000), as it is printed: a Helmholtz energy.

Its derivatives give heat capacity, enthalpy and entropy in closed form, so that nothing is integrated or fitted here.
"""

from math import exp, expm1, log, log1p

R = 8.31451 / 28.9586e-3
"""Gas constant of the paper over its molar mass [J/(kg K)]."""
REDUCING = 132.6312
POWERS = (
    (0.605719400e-7, -3.0),
    (-0.210274769e-4, -2.0),
    (-0.158860716e-3, -1.0),
    (17.275266575, 1.0),
    (-0.195363420e-3, 1.5),
)
LOG = 2.490888032
EINSTEIN = ((0.791309509, 25.36365), (0.212236768, 16.90741))
DISSOCIATED, RATE = -0.197938904, 87.31279


def slope(temperature):
    """tau times the slope of alpha_0 over tau, of the part that depends on temperature."""
    tau = REDUCING / temperature
    found = sum(n * power * tau**power for n, power in POWERS) + LOG
    found += sum(n * rate * tau / expm1(rate * tau) for n, rate in EINSTEIN)
    return found + DISSOCIATED * RATE * tau / (1.0 + 2.0 / 3.0 * exp(-RATE * tau))


def heat_capacity(temperature):
    """cp [J/(kg K)]: R (1 - tau^2 d2 alpha_0 / d tau2)."""
    tau = REDUCING / temperature
    curvature = sum(n * power * (power - 1.0) * tau**power for n, power in POWERS) - LOG
    curvature -= sum(n * (rate * tau) ** 2 * exp(rate * tau) / expm1(rate * tau) ** 2 for n, rate in EINSTEIN)
    share = 2.0 / 3.0 * exp(-RATE * tau)
    curvature += DISSOCIATED * (RATE * tau) ** 2 * share / (1.0 + share) ** 2
    return R * (1.0 - curvature)


def enthalpy(temperature):
    """h [J/kg], but for a constant."""
    return R * temperature * (1.0 + slope(temperature))


def entropy(temperature, pressure=1e5):
    """s [J/(kg K)], but for a constant: tau d alpha_0 / d tau - alpha_0, the density by the ideal gas law."""
    tau = REDUCING / temperature
    alpha = sum(n * tau**power for n, power in POWERS) + LOG * log(tau)
    alpha += sum(n * log1p(-exp(-rate * tau)) for n, rate in EINSTEIN)
    alpha += DISSOCIATED * (RATE * tau + log1p(2.0 / 3.0 * exp(-RATE * tau)))
    return R * (slope(temperature) - alpha - log(pressure / temperature))
