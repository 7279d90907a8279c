"""The valve over pressure and temperature of its control air (Figs. 8-11 of doi 10.1631/jzus.A0820373)."""

from itertools import product

import numpy as np

from apesim.archive import Archive, Variable
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
    return {
        "run": Variable(("run",), np.arange(len(grid)), "1", "number of the run"),
        "supply_pressure": Variable(
            ("run",), np.array([p for p, *_ in grid]), "Pa abs", "pressure of the control air", coordinate=True
        ),
        "supply_temperature": Variable(
            ("run",), np.array([t for _, t, *_ in grid]), "K", "temperature of the control air", coordinate=True
        ),
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
        "status": Variable(
            ("run",),
            np.array([run.status for run in runs], dtype=np.int8),
            "1",
            "how the march ended",
            STATUS_MEANINGS,
        ),
        "control_air_kg": Variable(
            ("run",), np.array([run.control_air for run in runs]), "kg", "control air of an opening and a closing"
        ),
    }
    for stroke in ("opening", "closing"):
        for field, (name, unit, description) in MEASURES.items():
            values = np.array([getattr(getattr(run, stroke), field) for run in runs])
            flag = values.dtype == bool
            variables[f"{stroke}_{name}"] = Variable(
                ("run",), values.astype(np.int8 if flag else float), unit, description, "0 no, 1 yes" if flag else ""
            )
    for name, (column, unit, description) in TRACES.items():
        values = np.stack([run.trace[:, column] for run in runs])
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
    v = {name: variable.values for name, variable in archive.variables.items()}
    lines = []
    for run, status in enumerate(v["status"]):
        where = f"run {run} ({v['supply_pressure'][run] / 1e6:g} MPa abs, {v['supply_temperature'][run]:g} K)"
        if status != Status.DONE:
            lines.append(f"{where}: failed: {Status(status).remedy}")
        elif np.isnan(v["opening_stroke_time_s"][run] + v["closing_stroke_time_s"][run]):
            lines.append(f"{where}: a stroke is not completed within the pulse")
    return lines
