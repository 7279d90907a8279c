"""Four intakes at 1000 r/min, 1.0 MPa gauge and 287 K, behind a receiver of 1 L: torque and air."""

import apesim
from docs.results import Number

NAMES = {"epv": "uncorrected", "epv corrected": "corrected", "cam": "cam", "ideal": "ideal"}


def compute():
    """Torques and specific air of each intake, and the angles at which the EPV is switched and really opens."""
    sweep = apesim.sweep(apesim.Machine(), speed="1000 rpm", intake=["epv", "cam", "ideal"], timing="both")
    values = {}
    for _, row in sweep.to_pandas().iterrows():
        name = NAMES[row["actuation"]]
        values[f"{name}.indicated_torque"] = Number(row["indicated_torque"], "N·m", error=0.005)
        values[f"{name}.brake_torque"] = Number(row["brake_torque"], "N·m", error=0.005)
        values[f"{name}.specific_air"] = Number(row["specific_air_kg_per_kWh"], "kg/kWh", error=0.05)
        for key in ("energise_deg", "release_deg", "valve_open_deg", "valve_close_deg"):
            if row["intake"] == "epv":
                values[f"{name}.{key.removesuffix('_deg')}"] = Number(row[key], "°", error=0.05)
    return values
