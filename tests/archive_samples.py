"""Small archives for the tests, and what it means that two are the same."""

import numpy as np

from apesim.archive import Archive, Variable
from tests.folders import SAMPLES

VERSION_1 = SAMPLES / "version_1.h5"
"""`sample()` as apesim 0.1.0 wrote it, before archives had digests."""
VERSION_2 = VERSION_1.with_name("version_2.h5")
"""`sample()` as it was written before archives followed the CF conventions."""
VERSION_2_SWEEP = VERSION_1.with_name("version_2_sweep.h5")
"""Three runs of a sweep, some of their results and every 120th sample of their traces, from the same time."""

MACHINE = '[engine]\nbore = "90 mm"\nstroke = "90 mm"\n# Übermaß\n[valve.solenoid]\ndead_time = "2 ms"\n'


def sample(runs=(0, 1, 2), angles=5, **provenance):
    """Each number is decided by its run, so that overlapping parts agree."""
    runs = np.array(runs, dtype=np.int64)
    angle = np.linspace(0.0, 720.0, angles)
    pressure = 1e5 * np.sin(runs[:, None] + angle[None, :] / 100.0)
    return Archive(
        MACHINE,
        {"created": "2024-01-01T00:00:00+00:00", "plan_hash": "p", **provenance},
        {
            "run": Variable(("run",), runs, "1", "run number"),
            "crank_angle": Variable(("crank_angle",), angle, "deg", "crank angle"),
            "speed": Variable(("run",), runs * 100.0 + 0.1, "rpm", "speed", finite=True),
            "torque": Variable(("run",), np.where(runs % 2, np.nan, runs / 3.0), "N m", "brake torque"),
            "cycles": Variable(("run",), runs + 7, "1", "cycles until periodic"),
            "intake": Variable(("run",), (runs % 2).astype(np.int8), "1", "intake", meanings="0 epv, 1 cam"),
            "warning": Variable(
                ("run",),
                np.array([("", 'größer, "α"')[i % 2] for i in runs.tolist()], dtype=str),
                "1",
                "warnings",
            ),
            "cylinder_pressure": Variable(("run", "crank_angle"), pressure, "Pa abs", "pressure in the cylinder"),
        },
    )


def same(a, b):
    return (
        a.machine == b.machine
        and list(a.variables) == list(b.variables)
        and all(same_variable(a.variables[name], b.variables[name]) for name in a.variables)
    )


def same_variable(a, b):
    described = [
        (v.dims, v.unit, v.description, v.meanings, v.finite, v.coordinate, v.kind, v.values.shape) for v in (a, b)
    ]
    if described[0] != described[1]:
        return False
    return a.values.tolist() == b.values.tolist() if a.kind == "text" else a.values.tobytes() == b.values.tobytes()
