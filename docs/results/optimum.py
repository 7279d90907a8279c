"""Command angles for most torque, least specific air and the front between both, at 1.0 MPa gauge and 287 K."""

import numpy as np

import apesim
from docs.results import Number, Table
from docs.results._figures import keep

LONG = True
NAMES = {
    "fixed": "fixed",
    "least_air": "for least specific air",
    "front": "at the ideal valve's torque, on the front",
    "most_torque": "for most torque",
}


def compute():
    """Best commands at 1000 and 1800 r/min, and with the supply pressure free."""
    machine = apesim.Machine()
    best = apesim.optimise_commands(machine, speed="600 rpm, 900 rpm, 1000 rpm, 1200 rpm, 1500 rpm, 1800 rpm")
    keep(best.draw, pareto_fronts="optimum_fronts", optimum_torque_and_air="optimum_over_speed")
    points = {round(point["speed_rpm"]): point for point in best.to_dict()["points"]}
    ideal = apesim.run_engine(machine.with_(engine_intake="ideal"), speed="1000 rpm")["brake_torque"]
    chosen = _at_torque(machine, points[1000]["front"], ideal)
    rows = [_row(NAMES[key], (points[1000] | {"front": chosen})[key]) for key in NAMES]
    heads = ["commands", "energise [°]", "release [°]", "valve opens [°]", "valve closes [°]"]
    heads += ["brake torque [N·m]", "all air over brake work [kg/kWh]"]
    return {
        "table": Table(heads, rows),
        "ideal_torque": Number(ideal, "N·m", error=0.005),
        "least_air_1800": Number(points[1800]["least_air"]["brake_torque_Nm"], "N·m", error=0.05),
        "most_torque_1800": Number(points[1800]["most_torque"]["brake_torque_Nm"], "N·m", error=0.05),
        "fixed_1800": Number(points[1800]["fixed"]["brake_torque_Nm"], "N·m", error=0.05),
        "front": Number(len(points[1000]["front"])),
        "sketches": Number(points[1000]["sketches"], error=20.0),
        "runs": Number(points[1000]["runs"], error=20.0),
        **_free(machine),
    }


def _at_torque(machine, front, torque):
    """Run the commands at which the front, interpolated over its torque, gives a torque."""
    torques = [point["brake_torque_Nm"] for point in front]
    angles = (np.interp(torque, torques, [point[f"{edge}_deg"] for point in front]) for edge in ("energise", "release"))
    energise, release = (float(angle) for angle in angles)
    run = apesim.run_engine(
        machine.with_(command_energise=(energise, "deg"), command_release=(release, "deg")), speed="1000 rpm"
    )
    data = run.to_dict()
    return {"energise_deg": energise, "release_deg": release, **data}


def _row(name, point):
    keys = ("energise_deg", "release_deg", "valve_open_deg", "valve_close_deg")
    angles = [Number(point[key], "°", error=0.05) for key in keys]
    torque = Number(point["brake_torque_Nm"], "N·m", error=0.005)
    return [name, *angles, torque, Number(point["specific_air_kg_per_kWh"], "kg/kWh", error=0.05)]


def _free(machine):
    """The pressure of least specific air, and whether it is the highest that is searched."""
    found = apesim.optimise_commands(
        machine, goal="air", speed="1000 rpm", free="supply.pressure=0.5 MPa gauge:1.5 MPa gauge"
    )
    [point] = found.to_dict()["points"]
    pressure = (point["least_air"]["supply_pressure"] - machine.ambient.pressure) / 1e6
    return {
        "free.pressure": Number(pressure, "MPa", error=0.005),
        "free.air": Number(point["least_air"]["specific_air_kg_per_kWh"], "kg/kWh", error=0.05),
    }
