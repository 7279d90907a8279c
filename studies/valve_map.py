"""The valve over pressure and temperature of its control air (Figs. 8-11 of doi 10.1631/jzus.A0820373)."""

from itertools import product

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.columns import column, run_axis, run_text, values_of
from apesim.kernel import sources_hash
from apesim.march.adaptive import Status
from apesim.quantities.settings import dumps
from apesim.studies.sweep import STATUS_MEANINGS
from apesim.valve.bench import run_bench

PRESSURES = "0.1:1.9:0.2 MPa gauge"
TEMPERATURES = "250:322:8 K"
"""The paper's grid."""
PULSE = 50e-3
SAMPLE = 0.1e-3
MEASURES = {
    "delay": ("delay_s", "s", "delay time t_d: command edge to 1 % of the stroke"),
    "stroke_time": ("stroke_time_s", "s", "full stroke time t_f: from there to contact"),
    "seating_speed": ("seating_speed_m_s", "m/s", "seating speed v_e: speed just before contact"),
    "fluctuation": ("fluctuation", "1", "(peak speed - lowest later speed before contact)/peak"),
    "reverses": ("reverses", "1", "whether the motion turns back before contact"),
}
"""Field of `apesim.valve.measures.Stroke`: its name in files, unit and what it is."""
TRACES = {
    "lift": (0, "m", "lift"),
    "velocity": (1, "m/s", "velocity of the lift, positive as it opens"),
    "pressure_a": (2, "Pa abs", "pressure of chamber A, which pushes to closed"),
    "pressure_b": (3, "Pa abs", "pressure of chamber B, which pushes to open"),
}


def with_supply(machine, pressure, temperature):
    """A machine with other control air.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    pressure : float
        [Pa abs]
    temperature : float
        [K]

    Returns
    -------
    apesim.engine.machine.Machine
    """
    supply = machine.supply._replace(pressure=pressure, temperature=temperature, control_pressure=float("nan"))
    return machine._replace(supply=supply)


def supply_columns(grid):
    """The axis of runs, and the control air of each.

    Parameters
    ----------
    grid : sequence of tuple
        Pressure [Pa abs] and temperature [K] of each run; what stands behind them is passed over.

    Returns
    -------
    dict of str to Variable
    """
    pressures, temperatures = [p for p, *_ in grid], [t for _, t, *_ in grid]
    return {
        "run": run_axis(len(grid)),
        "supply_pressure": column(pressures, "Pa abs", "pressure of the control air", coordinate=True),
        "supply_temperature": column(temperatures, "K", "temperature of the control air", coordinate=True),
    }


def map_valve(machine, pressures, temperatures, pulse=PULSE, command="", report=None):
    """Bench runs over a grid of pressures and temperatures.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    pressures : sequence of float
        [Pa abs]
    temperatures : sequence of float
        [K]
    pulse : float
        [s]
    command : str
        The command line, for the archive.
    report : function, optional
        Called with the numbers of runs done and in all.

    Returns
    -------
    Archive
        Run ``i len(temperatures) + j`` is pressure i and temperature j.
    """
    grid = list(product(pressures, temperatures))
    runs = []
    for done, (pressure, temperature) in enumerate(grid):
        runs.append(run_bench(with_supply(machine, pressure, temperature), pulse, sample=SAMPLE))
        if report:
            report(done + 1, len(grid))
    variables = {
        **supply_columns(grid),
        "time": Variable(("time",), runs[0].times, "s", "time after the solenoids are energised"),
        "status": column([run.status for run in runs], "1", "how the march ended", STATUS_MEANINGS),
        "control_air_kg": column([run.control_air for run in runs], "kg", "control air of an opening and a closing"),
    }
    for stroke in ("opening", "closing"):
        for field, (name, unit, description) in MEASURES.items():
            values = [getattr(getattr(run, stroke), field) for run in runs]
            variables[f"{stroke}_{name}"] = column(values, unit, description)
    for name, (number, unit, description) in TRACES.items():
        values = np.stack([run.trace[:, number] for run in runs])
        variables[name] = Variable(("run", "time"), values, unit, description)
    provenance = {"command": command, "kernels": sources_hash(), "pulse_s": repr(pulse)}
    return Archive(dumps(machine), provenance, variables)


def faults_of_map(archive):
    """One line for each run that failed or did not complete both strokes.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    list of str
    """
    v, lines = values_of(archive), []
    for run, status in enumerate(v["status"]):
        where = run_text(archive, run)
        if status != Status.DONE:
            lines.append(f"{where}: failed: {Status(status).remedy}")
        elif np.isnan(v["opening_stroke_time_s"][run] + v["closing_stroke_time_s"][run]):
            lines.append(f"{where}: a stroke is not completed within the pulse")
    return lines
