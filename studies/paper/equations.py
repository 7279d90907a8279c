"""What the paper puts into its equations: gauge pressures, the sign of the outflow."""

from studies.paper.claim import CONTRADICTED, Claim
from studies.valve_map import PULSE
from valve.bench import run_bench


def gauge_pressures(machine, pressure=0.4e6, k=1.4):
    """The pressures are gauge, Eqs. 7-10 need absolute ones."""
    absolute = pressure + machine.ambient.pressure
    ratio = absolute / pressure
    return Claim(
        "gauge_pressures",
        "Eqs. 7-10, Figs. 3-4",
        "Pressures are given relative to ambient, and put into Eqs. 7-10.",
        "gauge",
        f"Eq. 10 with gauge pressures gives {100 * (ratio - 1.0):.0f} % too large an area at the start of a discharge "
        "from 0.4 MPa",
        {"area_ratio": ratio, "exponent": (1.0 - 3.0 * k) / (2.0 * k) + (k - 1.0) / (2.0 * k)},
        CONTRADICTED,
        "At p = p_ini the pressures of Eq. 10 have the exponent -1 in all. apesim takes absolute pressures only.",
    )


def sign_of_outflow(machine):
    """Eq. 4 adds dm_out."""
    run = run_bench(machine, PULSE)
    return Claim(
        "sign_of_outflow",
        "Eq. 4",
        "The mass of a chamber changes by the inflow plus the outflow.",
        "dm = dm_in + dm_out",
        f"with Eq. 7's positive flows it is the difference; so counted, mass closes to {run.closure['mass']:.0e}",
        {"mass_closure": run.closure["mass"]},
        CONTRADICTED,
        "Right only where dm_out is taken to be negative, which the paper does not say.",
    )
