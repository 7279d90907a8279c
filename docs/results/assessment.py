"""What lateness, finite speed and control air cost at 1000 r/min, 1.0 MPa gauge and 287 K."""

import apesim
from docs.results import Number, Table

ORDERS = {"lateness_first": "lateness first", "finite_speed_first": "finite speed first", "mean": "mean"}
CAUSES = {
    "lateness": "lateness",
    "finite_speed": "finite speed",
    "fluctuation": "of it fluctuation",
    "control_air": "control air",
}
TERMS = ("engine_air", "control_air", "indicated_work", "feed", "groove", "exhaust", "valve_drive", "other")


def compute():
    """Changes of brake torque and of air over brake work by each cause in each order, lateness, and exergy."""
    values = {}
    for timing in ("fixed", "corrected"):
        assessment = apesim.assess_valve(apesim.Machine(), speed="1000 rpm", timing=timing)
        [point] = assessment.to_dict()["points"]
        values |= _compare_losses(timing, point["losses"])
        if timing == "fixed":
            values |= {f"fixed.{key}": value for key, value in _describe_lateness(point).items()}
    return values


def _compare_losses(timing, losses):
    """Tables of what each cause costs, by the order in which the causes are taken away."""
    tables = {}
    for key, what, unit, sign, name in (
        ("torque", "brake torque", "N·m", -1.0, "brake_torque_lost_Nm"),
        ("air", "air over brake work", "kg/kWh", 1.0, "specific_air_added_kg_per_kWh"),
    ):
        rows = [
            [words, *(Number(sign * losses[order][cause][name], unit, error=0.05) for order in ORDERS)]
            for cause, words in CAUSES.items()
        ]
        tables[f"{timing}.{key}"] = Table([f"change of {what} [{unit}]", *ORDERS.values()], rows)
    return tables


def _describe_lateness(point):
    """How late the valve opens and closes, and the exergy of a cycle with it and with the ideal valve."""
    keys = {"opens_late": "opening_lateness", "closes_late": "closing_lateness"}
    keys |= {"opening_delay": "opening_delay", "closing_delay": "closing_delay"}
    values = {key: Number(point[f"{name}_deg"], "°", error=0.05) for key, name in keys.items()}
    rows = []
    for key in ("ideal", "real"):
        terms = {term: point["valves"][key][f"exergy_{term}_J"] for term in TERMS}
        values[f"{key}.brought"] = Number(terms["engine_air"] + terms["control_air"], "J", error=0.5)
        values[f"{key}.indicated_work"] = Number(terms["indicated_work"], "J", error=0.5)
        rows.append([f"{key} valve", *(Number(term, "J", error=0.5) for term in terms.values())])
    return values | {"exergy": Table(["", *(f"{term.replace('_', ' ')} [J]" for term in TERMS)], rows)}
