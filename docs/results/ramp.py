"""Commands through ramps of 300, 1800 and 300 r/min: brake work, air, true angles, and how far steady runs are off."""

import tempfile
from functools import partial
from pathlib import Path

import numpy as np

import apesim
from apesim.engine.angles import DEGREE, RPM
from apesim.quantities import Arguments
from apesim.studies.drawing.files import write_figures
from apesim.studies.transient.courses import read_timing
from docs.results import Number, Table
from docs.results._figures import keep

LONG = True
TARGETS = -5.0, 70.0
RAMPS = 1.5, 3.0, 12.0
"""Times of the ramps, up and down [s]."""
SETTLING = 2.0
"""Time at 300 r/min before a ramp whose start is not to count [s]."""
FLOORS = None, "7.8 ms", "10 ms"
SPEEDS = np.arange(300.0, 1801.0, 50.0)
"""Speeds of the steady runs [r/min]."""
LEAD = "speed [rpm],energise [deg],release [deg]\n0,-5,70\n2500,-95,-65\n"
"""Lead times of 6 ms and 9 ms."""
STYLES = {
    "fixed": ("C0", "-", "o"),
    "lead times": ("C1", "--", "s"),
    "map": ("C2", "-.", "^"),
    "feedback": ("C3", ":", "D"),
}
"""Colour, line and marker of each command in the figures."""


def compute():
    """March the ramps with all commands, and steady runs at their speeds; draw angles, torque and cost."""
    machine = apesim.Machine()
    with tempfile.TemporaryDirectory() as folder:
        timings = _timings(machine, Path(folder))
        runs = {
            (name, floor, ramp): _march(machine, timing, floor, ramp)
            for name, timing in timings.items()
            for floor in FLOORS
            for ramp in RAMPS
        }
        settled = {
            (name, ramp): _march(machine, timings[name], None, ramp, SETTLING) for name in timings for ramp in RAMPS
        }
        steady = {name: _steady(machine, timings[name]) for name in ("fixed", "lead times", "map")}
    figures = {
        "angles": partial(_draw_angles, settled),
        "torque": partial(_draw_torque, settled, steady),
        "cost": partial(_draw_cost, runs),
    }
    keep(partial(write_figures, figures), angles="ramp_angles", torque="ramp_torque", cost="ramp_cost")
    return {
        "costs": _costs(runs),
        "angles": _angles(settled),
        "ramps": _ramps(runs, settled),
        "quasi_steady": _quasi_steady(settled, steady),
        **_numbers(runs, settled, steady),
        **_pulses(machine),
    }


def _timings(machine, folder):
    """What `timing` is for each command, with files in a folder."""
    (folder / "lead.csv").write_text(LEAD)
    apesim.correct_timing(
        machine,
        target="-5 deg, 70 deg",
        speed="300:1800:100 rpm",
        pressure="1 MPa gauge",
        temperature="287 K",
        out=folder / "map.h5",
    )
    return {"fixed": "fixed", "lead times": folder / "lead.csv", "map": folder / "map.csv", "feedback": "feedback"}


def _march(machine, timing, floor, ramp, settling=0.0):
    """March one ramp, after a time at its lowest speed."""
    course = f"{settling + ramp / 2:g} s: 1800 rpm, {settling + ramp:g} s: 300 rpm"
    start = "0 s: 300 rpm, " + (f"{settling:g} s: 300 rpm, " if settling else "")
    return apesim.run_transient(machine, speed=start + course, timing=timing, min_pulse=floor)


def _steady(machine, timing):
    """Brake work [J] and air [kg] of a turn in steady runs over `SPEEDS`, by the commands that a timing has there."""
    rows = read_timing(Arguments("run_transient"), machine, timing)[0]
    angles = [np.interp(SPEEDS * RPM, rows[:, 0], rows[:, column]) / DEGREE for column in (1, 2)]
    machines = [
        machine.with_(**{"command.energise": (energise, "deg"), "command.release": (release, "deg")})
        for energise, release in zip(*np.array(angles).tolist(), strict=True)
    ]
    traces = apesim.run_many(machines, (SPEEDS, "rpm"), jobs=None).traces
    assert traces["converged"].values.all()
    return 2.0 * np.pi * traces["brake_torque"].values, traces["engine_air"].values + traces["control_air"].values


def _revolutions(run):
    """Revolutions of a ramp: middle in time from its start, speed, work, air, errors of both angles, whether rising."""
    r, own = run.march.revolutions, run.march.cylinders
    middle = r["start"] + 0.5 * r["duration"] - SETTLING
    errors = np.stack([own[name][:, 0] / DEGREE for name in ("open", "close")]) - np.reshape(TARGETS, (2, 1))
    columns = (
        *(middle, 60.0 / r["duration"], r["gas_work"] - r["friction_work"], r["engine_air"] + r["control_air"]),
        *(*errors, middle < 0.5 * (run["duration"] - SETTLING)),
    )
    return [column[middle > 0.0] for column in columns]


def _air(run):
    return 1e3 * (run["engine_air"] + run["control_air"])


def _costs(runs):
    heads = [
        "commands",
        "shortest pulse",
        "brake work [J]",
        "all air [g]",
        "work over air [J/g]",
        "strokes",
        "cut short",
    ]
    rows = []
    for (name, floor, ramp), run in runs.items():
        if ramp == 3.0:
            row = [name, (floor or "–").replace(" ", "\u00a0"), Number(run["brake_work"], "J", error=0.5)]
            row += [Number(_air(run), "g", error=0.05), Number(run["specific_work_J_per_g"], "J/g", error=0.05)]
            rows.append([*row, *(Number(run[key], error=0.5) for key in ("revolutions", "strokes_cut_short"))])
    return Table(heads, rows)


def _rms(errors):
    return float(np.sqrt(np.nanmean(errors**2)))


def _angles(settled):
    heads = ["commands"]
    heads += [f"{edge}: {what} [°]" for edge in ("opening", "closing") for what in ("rms", "from", "to")]
    rows = []
    for name in STYLES:
        errors = _revolutions(settled[name, 3.0])[4:6]
        values = [value for each in errors for value in (_rms(each), np.nanmin(each), np.nanmax(each))]
        rows.append([name, *(Number(float(value), "°", error=0.05) for value in values)])
    return Table(heads, rows)


def _ramps(runs, settled):
    heads = ["commands", *(f"{ramp:g} s: {what}" for ramp in RAMPS for what in ("[J/g]", "opening [°]", "closing [°]"))]
    rows = []
    for name in STYLES:
        row = [name]
        for ramp in RAMPS:
            row.append(Number(runs[name, None, ramp]["specific_work_J_per_g"], "J/g", error=0.05))
            row += [Number(_rms(each), "°", error=0.05) for each in _revolutions(settled[name, ramp])[4:6]]
        rows.append(row)
    return Table(heads, rows)


def _misses(run, steady):
    """How far steady runs are off in brake work and air: in the rise, in the fall and in both [%]."""
    _, speed, work, air, _, _, rising = _revolutions(run)
    misses = []
    for own, of_steady in zip((work, air), steady, strict=True):
        found = np.interp(speed, SPEEDS, of_steady)
        misses += [1e2 * (found[part].sum() / own[part].sum() - 1.0) for part in (rising, ~rising, rising | ~rising)]
    return misses


def _quasi_steady(settled, steady):
    heads = [
        "commands",
        "ramp [s]",
        *(f"{what}, {part} [%]" for what in ("work", "air") for part in ("up", "down", "both")),
    ]
    rows = []
    for name in steady:
        for ramp in RAMPS:
            misses = _misses(settled[name, ramp], steady[name])
            rows.append([name, f"{ramp:g}", *(Number(miss, "%", error=0.05) for miss in misses)])
    return Table(heads, rows)


def _numbers(runs, settled, steady):
    values = {}
    fixed = runs["fixed", None, 3.0]
    for name, floor in (("lead times", "7.8 ms"), ("lead times", "10 ms"), ("map", None), ("feedback", None)):
        run, key = runs[name, floor, 3.0], name.replace(" ", "_") + (f".{floor[:-3]}" if floor else "")
        values[f"{key}.more_work"] = Number(1e2 * (run["brake_work"] / fixed["brake_work"] - 1.0), "%", error=0.5)
        values[f"{key}.less_air"] = Number(1e2 * (1.0 - _air(run) / _air(fixed)), "%", error=0.5)
    misses = {key: _misses(run, steady[key[0]]) for key, run in settled.items() if key[0] in steady}
    one_way = [abs(miss) for (_, ramp), each in misses.items() if ramp == 3.0 for miss in (each[0], each[1])]
    one_way_air = [abs(miss) for (_, ramp), each in misses.items() if ramp == 3.0 for miss in (each[3], each[4])]
    both = [abs(each[k]) for (_, ramp), each in misses.items() if ramp == 3.0 for k in (2, 5)]
    slow = [abs(miss) for (_, ramp), each in misses.items() if ramp == 12.0 for miss in each]
    started = []
    for name in steady:
        work, air = (float(np.trapezoid(each * SPEEDS / 60.0, SPEEDS)) * 3.0 / 1500.0 for each in steady[name])
        run = runs[name, None, 3.0]
        started += [1e2 * (1.0 - work / run["brake_work"]), 1e2 * (1.0 - 1e3 * air / _air(run))]
    for key, found in {"work": one_way, "air": one_way_air, "started": started}.items():
        values[f"miss.{key}.least"] = Number(min(found), "%", error=0.5)
        values[f"miss.{key}.most"] = Number(max(found), "%", error=0.5)
    values["miss.both.most"] = Number(max(both), "%", error=0.05)
    values["miss.slow.most"] = Number(max(slow), "%", error=0.5)
    return values


def _pulses(machine):
    """Lift of a single pulse of 7.8 ms, and the shortest one that meets the open stop, from rest on the bench."""
    low, high = 7.8, 12.0
    lift = 1e3 * float(apesim.run_valve(machine, pulse=(low, "ms")).traces["lift"].values.max())
    while high - low > 0.01:
        pulse = 0.5 * (low + high)
        is_met = np.isfinite(apesim.run_valve(machine, pulse=(pulse, "ms"))["opening_stroke_time"])
        low, high = (low, pulse) if is_met else (pulse, high)
    return {"pulse.lift": Number(lift, "mm", error=0.05), "pulse.shortest": Number(high, "ms", error=0.005)}


def _draw_angles(settled):
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 2, figsize=(6.5, 5.2), sharex=True, layout="constrained")
    for name, (colour, line, marker) in STYLES.items():
        middle, _, _, _, *errors, _ = _revolutions(settled[name, 3.0])
        for row, each in zip(axes, errors, strict=True):
            for ax in row:
                ax.plot(middle, each, line, color=colour, marker=marker, ms=3, fillstyle="none", label=name)
    for row, edge in zip(axes, ("opening", "closing"), strict=True):
        row[0].set(ylabel=f"error of the {edge} [deg]", ylim=(-75.0, 85.0))
        row[1].set(ylim=(-23.0, 23.0))
    for ax in axes.flat:
        ax.axhline(0.0, color="0.6", lw=0.8, zorder=0)
        ax.axvline(1.5, color="0.6", lw=0.8, zorder=0)
    axes[0, 0].set_title("all")
    axes[0, 1].set_title("close to the targets")
    for ax in axes[1]:
        ax.set(xlabel="time in the ramp [s]")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure


def _draw_torque(settled, steady):
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(6.5, 3.4), sharex=True, sharey=True, layout="constrained")
    for ax, name in zip(axes, ("fixed", "lead times", "map"), strict=True):
        _, speed, work, _, _, _, rising = _revolutions(settled[name, 3.0])
        torque = work / (2.0 * np.pi)
        ax.plot(SPEEDS, steady[name][0] / (2.0 * np.pi), "-", color="0.3", label="steady runs")
        ax.plot(speed[rising], torque[rising], "^", color="C0", ms=4, label="speed rises")
        ax.plot(speed[~rising], torque[~rising], "v", color="C1", ms=4, fillstyle="none", label="speed falls")
        ax.set(title=name, xlabel="speed [r/min]")
    axes[0].set_ylabel("brake torque [N m]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def _draw_cost(runs):
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots(figsize=(5.8, 4.2), layout="constrained")
    for name, (colour, line, marker) in STYLES.items():
        of = [runs[name, floor, 3.0] for floor in FLOORS]
        ax.plot(
            list(map(_air, of)), [1e-3 * run["brake_work"] for run in of], line, color=colour, marker=marker, label=name
        )
        if name == "lead times":
            for run, floor in zip(of, FLOORS, strict=True):
                place = _air(run), 1e-3 * run["brake_work"]
                ax.annotate(floor or "no floor", place, (8, -3), textcoords="offset points", color=colour, va="top")
    most = np.array([0.0, 210.0])
    for specific in (20.0, 40.0, 60.0, 80.0):
        ax.plot(most, 1e-3 * specific * most, "-", color="0.8", lw=0.8, zorder=0)
        at = min(most[1], 13e3 / specific)
        ax.annotate(f"{specific:g} J/g", (at, 1e-3 * specific * at), color="0.4", ha="right", va="bottom", fontsize=8)
    ax.set(xlabel="all air [g]", ylabel="brake work [kJ]", xlim=(50.0, 210.0), ylim=(3.0, 13.5))
    figure.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure
