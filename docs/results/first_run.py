"""What the commands and the Python of the first run print on the default machine."""

import apesim
from docs.results import Number
from docs.results._terminal import run, session


def compute():
    """Run the valve on its bench, the engine at 1000 r/min and with less pressure, a small sweep, and Python."""
    weak = apesim.run_engine(apesim.Machine().with_(supply_pressure="0.6 MPa gauge"), speed="1000 rpm")
    sweep = ("--speed", "600 rpm, 1200 rpm", "--intake", "epv", "--out", "mine.h5", "--no-figures")
    return {
        "valve": run("valve", "run", "--supply", "0.49 MPa gauge", "--pulse", "50 ms"),
        "engine": run("engine", "run", "--speed", "1000 rpm"),
        "weak.torque": Number(weak["brake_torque"], "N·m", error=0.05),
        "weak.air": Number(weak["specific_air_kg_per_kWh"], "kg/kWh", error=0.5),
        "weak.opens": Number(weak["valve_open_deg"], "°", error=0.05),
        "small_sweep": run("engine", "sweep", *sweep),
        "no_unit": run("engine", "run", "--speed", "1000 rpm", "--set", "supply.pressure=0.6", ending=2),
        "which_pressure": run("engine", "run", "--speed", "1000 rpm", "--set", "supply.pressure=0.6 MPa", ending=2),
        "unknown_key": run("engine", "run", "--speed", "1000 rpm", "--set", "engine.boer=90 mm", ending=2),
        "python": session(
            "import apesim",
            "machine = apesim.Machine()",
            'run = apesim.run_engine(machine, speed="1000 rpm")',
            "run",
            'run["brake_torque"], run.scalars["brake_torque"].unit',
            'run.traces["lift"]',
            'weak = machine.with_(supply_pressure="0.6 MPa gauge")',
            'round(apesim.run_engine(weak, speed="1000 rpm")["brake_torque"], 1)',
        ),
    }
