"""Measured data: a folder with ``measured.toml`` and the CSV files that it names, of one of three benches.

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

A cylinder's bench: a drive moves the piston slowly to and fro, one chamber is pressurised::

    bench = "cylinder"
    [[run]]
    data = "o_ring_1_bar.csv"        # header: time [ms], stroke [mm], pressure [bar gauge], force [N]
    supply = "1 bar gauge"
    role = "fit"

A laboratory's own files are read by a table ``[read]``, of the folder or of a run::

    [read]
    separator = "tab"                # guessed if left out, as are decimal and encoding
    decimal = ","
    skip_rows = 4
    columns = { time = "Zeit (s)", lift = "Ch1" }
    unit.lift = "mm"
    ignore_others = true

How far the rig is known is said by a table ``[known_to]``, each value a standard deviation::

    [known_to]
    "valve.stroke" = "0.05 mm"       # a key of the machine file
    "sensor.lift.gain" = "0.2 %"
    "valve.viscous_friction" = "exact"

By how much numbers differ from run to run is said by a table ``[scatter]``, or told by repeats::

    [scatter]
    "supply.pressure" = "0.3 %"

Inside all is SI and absolute. In the order in which they build on one another: runs (what a run is), conversion (of
numbers to SI), dialect (how a file is written), text_blocks (its text), cells (what a cell may say), layout (where
header and numbers stand), table (its numbers), row_order (whether its rows rise), columns (in SI), folder_file (how
``measured.toml`` says all this), thinning (of long records), sensors (what can be measured), stated_uncertainties (how
far the rig is known), scatter (by how much runs differ), strokes (strokes of a cylinder), reading (the folder),
arguments (of a call), lineage (of machine files), prediction (what a machine would have shown), plausibility (whether
the data can be what they say), check (all of that), figures.
"""

from apesim.studies.measured.reading import read_measured
from apesim.studies.measured.runs import (
    CHECK,
    CYLINDER,
    ENGINE,
    FIT,
    GATE,
    VALVE,
    Bench,
    Disturbance,
    Masked,
    Measured,
    MeasuredRun,
    Role,
)

__all__ = [
    "CHECK",
    "CYLINDER",
    "ENGINE",
    "FIT",
    "GATE",
    "VALVE",
    "Bench",
    "Disturbance",
    "Masked",
    "Measured",
    "MeasuredRun",
    "Role",
    "read_measured",
]
