"""Measured data: a folder with ``measured.toml`` and the CSV files that it names, of a valve's or an engine's bench.

A valve's bench::

    bench = "valve"
    [sensor.lift]
    noise = "0.03 mm"                # standard deviation; optional
    [[run]]
    data = "p040.csv"                # header: time [ms], lift [mm], pressure_a [kPa abs], ...
    supply = "0.40 MPa gauge"
    temperature = "287 K"
    pulse = "50 ms"
    role = "fit"                     # "gate": never fitted, refuses a model that it contradicts; "check": only reported

An engine's bench, at its periodic state; data, or one of the means, may be left out::

    bench = "engine"
    [sensor.torque]
    noise = "0.5 N m"
    [[run]]
    data = "n1000.csv"               # header: crank_angle [deg], cylinder_pressure [kPa abs], lift [mm], ...
    supply = "1.0 MPa gauge"
    temperature = "287 K"
    speed = "1000 rpm"
    energise = "-5 deg"              # when the solenoids are switched
    release = "70 deg"
    torque = "31.2 N m"              # mean brake torque
    air_flow = "12.3 g/s"            # mean of all air: engine's and control air

Inside all is SI and absolute. In the order in which they build on one another: runs (what a run is), columns (a
CSV), sensors (what can be measured), reading (the folder), prediction (what a machine would have shown).
"""

from apesim.studies.measured.reading import read_measured
from apesim.studies.measured.runs import CHECK, ENGINE, FIT, GATE, VALVE, Bench, Measured, MeasuredRun, Role

__all__ = ["CHECK", "ENGINE", "FIT", "GATE", "VALVE", "Bench", "Measured", "MeasuredRun", "Role", "read_measured"]
