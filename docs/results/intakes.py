"""Four intakes at 1000 r/min, 1.0 MPa gauge and 287 K, with a receiver of 1 L and an endless one: torque and air."""

import apesim
from docs.results import Number, Table

NAMES = {"epv": "fixed", "epv corrected": "corrected", "cam": "cam", "ideal": "ideal"}
SHOWN = {"ideal": "ideal valve", "cam": "cam", "corrected": "EPV, corrected", "fixed": "EPV, fixed"}
TERMS = {
    "exhaust_valve": "exhaust_valve",
    "groove": "groove",
    "feed": "feed",
    "mixing": "cylinder_mixing",
    "control_air": "control_air",
    "exhaust_air": "exhaust_air",
}


def compute():
    """Torques, specific air and exergy of each intake, and the angles at which the EPV is switched and really opens."""
    values, rows = {}, []
    for receiver, volume in (("1 L", "1 L"), ("endless", "inf")):
        machine = apesim.Machine().with_(engine_receiver_volume=volume)
        sweep = apesim.sweep(machine, speed="1000 rpm", intake=["epv", "cam", "ideal"], timing="both")
        runs = {NAMES[row["actuation"]]: row for _, row in sweep.to_pandas().iterrows()}
        rows += [[name, receiver, *_describe_run(runs[key]).values()] for key, name in SHOWN.items()]
        if receiver != "endless":
            for name, row in runs.items():
                values |= {f"{name}.{key}": value for key, value in (_describe_run(row) | _find_angles(row)).items()}
            values |= _compare_exergy(runs["fixed"], runs["corrected"])
    columns = ["intake", "receiver", "indicated torque [N·m]", "brake torque [N·m]", "all air over brake work [kg/kWh]"]
    return values | {"table": Table(columns, rows)}


def _describe_run(row):
    """Torques and specific air."""
    return {
        "indicated_torque": Number(row["indicated_torque"], "N·m", error=0.005),
        "brake_torque": Number(row["brake_torque"], "N·m", error=0.005),
        "specific_air": Number(row["specific_air_kg_per_kWh"], "kg/kWh", error=0.05),
    }


def _find_angles(row):
    """Angles at which the EPV is switched, and at which it or the cam's valve opens and closes."""
    keys = {"epv": ("energise", "release", "valve_open", "valve_close"), "cam": ("valve_open", "valve_close")}
    return {key: Number(row[f"{key}_deg"], "°", error=0.05) for key in keys.get(row["intake"], ())}


def _compare_exergy(late, corrected):
    """Exergy of both timings, and what the fixed one spends more."""
    values = {}
    for name, row in (("fixed", late), ("corrected", corrected)):
        brought = row["exergy_engine_air"] + row["exergy_control_air"]
        values |= {
            f"{name}.exergy_in": Number(brought, "J", error=0.5),
            f"{name}.indicated_work": Number(row["exergy_indicated_work"], "J", error=0.5),
            f"{name}.exhaust_celsius": Number(row["exhaust_temperature"] - 273.15, "°C", error=0.5),
        }
    for name, term in TERMS.items():
        more = late[f"exergy_{term}"] - corrected[f"exergy_{term}"]
        values[f"more_{name}"] = Number(abs(more) if name == "exhaust_air" else more, "J", error=0.5)
    for key in ("exergy_efficiency", "isothermal_efficiency"):
        values[f"fixed.{key}"] = Number(1e2 * late[key], "%", error=0.05)
    return values
