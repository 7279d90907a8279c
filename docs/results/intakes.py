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
    receivers = {"": apesim.Machine(), "endless.": apesim.Machine().with_(**{"engine.receiver.volume": "inf"})}
    values = {}
    for prefix, machine in receivers.items():
        sweep = apesim.sweep(machine, speed="1000 rpm", intake=["epv", "cam", "ideal"], timing="both")
        runs = {NAMES[row["actuation"]]: row for _, row in sweep.to_pandas().iterrows()}
        for name, row in runs.items():
            values |= _of_run(prefix + name, row)
        values |= _exergy(prefix, runs["fixed"], runs["corrected"])
    return values | {"table": _table(values)}


def _of_run(name, row):
    values = {
        f"{name}.indicated_torque": Number(row["indicated_torque"], "N·m", error=0.005),
        f"{name}.brake_torque": Number(row["brake_torque"], "N·m", error=0.005),
        f"{name}.specific_air": Number(row["specific_air_kg_per_kWh"], "kg/kWh", error=0.05),
    }
    for key in ("energise_deg", "release_deg", "valve_open_deg", "valve_close_deg"):
        if row["intake"] == "epv" or (row["intake"] == "cam" and key.startswith("valve")):
            values[f"{name}.{key.removesuffix('_deg')}"] = Number(row[key], "°", error=0.05)
    return values


def _exergy(prefix, late, corrected):
    values = {}
    for name, row in (("fixed", late), ("corrected", corrected)):
        brought = row["exergy_engine_air"] + row["exergy_control_air"]
        values |= {
            f"{prefix}{name}.exergy_in": Number(brought, "J", error=0.5),
            f"{prefix}{name}.indicated_work": Number(row["exergy_indicated_work"], "J", error=0.5),
            f"{prefix}{name}.exhaust_celsius": Number(row["exhaust_temperature"] - 273.15, "°C", error=0.5),
            f"{prefix}{name}.exergy_efficiency": Number(1e2 * row["exergy_efficiency"], "%", error=0.05),
            f"{prefix}{name}.isothermal_efficiency": Number(1e2 * row["isothermal_efficiency"], "%", error=0.05),
        }
    for name, term in TERMS.items():
        more = late[f"exergy_{term}"] - corrected[f"exergy_{term}"]
        values[f"{prefix}more_{name}"] = Number(abs(more) if name == "exhaust_air" else more, "J", error=0.5)
    return values


def _table(values):
    rows = []
    for prefix, receiver in (("", "1 L"), ("endless.", "endless")):
        for key, name in SHOWN.items():
            numbers = (values[f"{prefix}{key}.{what}"] for what in ("indicated_torque", "brake_torque", "specific_air"))
            rows.append([name, receiver, *numbers])
    columns = ["intake", "receiver", "indicated torque [N·m]", "brake torque [N·m]", "all air over brake work [kg/kWh]"]
    return Table(columns, rows)
