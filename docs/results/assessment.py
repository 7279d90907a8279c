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
        values |= {f"{timing}.{key}": value for key, value in _of_point(point).items()}
    return values


def _of_point(point):
    torque, air = ({}, {})
    for order in ORDERS:
        for cause in CAUSES:
            lost = point["losses"][order][cause]
            torque[cause, order] = Number(-lost["brake_torque_lost_Nm"], "N·m", error=0.05)
            air[cause, order] = Number(lost["specific_air_added_kg_per_kWh"], "kg/kWh", error=0.05)
    values = {
        "torque": _table("brake torque [N·m]", torque),
        "air": _table("air over brake work [kg/kWh]", air),
        "opens_late": Number(point["opening_lateness_deg"], "°", error=0.05),
        "closes_late": Number(point["closing_lateness_deg"], "°", error=0.05),
        "opening_delay": Number(point["opening_delay_deg"], "°", error=0.05),
        "closing_delay": Number(point["closing_delay_deg"], "°", error=0.05),
    }
    rows = []
    for key, name in (("ideal", "ideal valve"), ("real", "real valve")):
        numbers = [Number(point["valves"][key][f"exergy_{term}_J"], "J", error=0.5) for term in TERMS]
        values |= {f"{key}.{term}": number for term, number in zip(TERMS, numbers, strict=True)}
        values[f"{key}.brought"] = Number(numbers[0].value + numbers[1].value, "J", error=0.5)
        rows.append([name, *numbers])
    columns = ["", *(f"{term.replace('_', ' ')} [J]" for term in TERMS)]
    return values | {"exergy": Table(columns, rows)}


def _table(what, numbers):
    rows = [[name, *(numbers[cause, order] for order in ORDERS)] for cause, name in CAUSES.items()]
    return Table([f"change of {what}", *ORDERS.values()], rows)
