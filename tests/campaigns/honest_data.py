"""Folders of measured data for the plausibility checks: honest ones, ones with an effect, and ones that are broken."""

import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.measured import read_measured
from apesim.studies.measured.plausibility import Finding, Kind, examine
from tests.truth.sealed.challenge import nominal_rig
from tests.truth.sealed.files import machine_file
from tests.truth.sealed.library import ENGINE, LIBRARY, VALVE
from tests.truth.sealed.nuisances import drawn, nuisances_for, with_nuisances
from tests.truth.sealed.observation import Laboratory, at_point, noisy
from tests.truth.sealed.setting import AMBIENT, RPM, WHITE, Noise, Point, Setting, draw_setting
from tests.truth.simulator.effects import EFFECTS
from tests.truth.simulator.sensors import MEANS
from tests.truth.simulator.valve import TEMPERATURE_A

NOISES = (0.5, 1.0, 3.0)
"""Times the usual noise: each run is recorded with each of them."""
BROKEN_RIGS = {VALVE: 8, ENGINE: 4}
"""Rigs whose data are broken on purpose, each in every way."""
UNITS = {"lift": "m", "torque": "N m", "air_flow": "kg/s", "temperature_a": "K"}
AXES = {VALVE: "time [s]", ENGINE: "crank_angle [rad]"}
STROKE = 9e-3
TEMPERATURE_NOISE = 1.0
"""Noise of a thermometer [K]."""


# --- folders ---


def honest(rng, bench):
    """Folders of a rig that is the machine but for nuisances: machine, runs, bench, in each noise."""
    nominal, setting = nominal_rig(rng, bench), draw_setting(rng, bench, SUITES_OF[bench])
    lab = Laboratory(setting)
    nuisances = nuisances_for(bench, setting.channels)
    values = drawn(nuisances, rng)
    shown = []
    for point in setting.points:
        rig = with_nuisances(at_point(nominal, point), nuisances, values)
        shown.append((point, lab.read(rig, point, lab.run(rig, point))))
    for scale in NOISES:
        louder = setting._replace(noise=setting.noise._replace(scale=scale))
        runs = [record(louder, point, noisy(louder, point, true, rng)) for point, true in shown]
        yield machine_file(bench, nominal), runs, bench


def with_effects(rng, bench, names, sigmas):
    """Folders of rigs with one effect each, at so many standard deviations, or at each end of its range."""
    nominal, setting = nominal_rig(rng, bench), plain_setting(bench, fits=2 if bench == VALVE else 1)
    lab = Laboratory(setting)
    for name in names:
        entry = LIBRARY[name]
        if bench not in entry.benches[:1]:
            continue
        besides = {key: float(rng.uniform(*ends)) for key, ends in entry.besides.items()}
        for end in entry.ends:

            def add(rig, share, name=name, entry=entry, end=end, besides=besides):
                return EFFECTS[name](rig, **besides, **{entry.parameter: entry.size(share, end) * entry.scale})

            share = 1.0 if sigmas is None else share_of(lab, nominal, add, sigmas)
            runs = []
            for point in setting.points:
                rig = add(at_point(nominal, point), share)
                runs.append(
                    record(setting, point, noisy(setting, point, lab.read(rig, point, lab.run(rig, point)), rng))
                )
            yield machine_file(bench, nominal), runs, bench


def share_of(lab, nominal, add, sigmas):
    """Share of its range at which an effect has a size, by two steps in proportion; all of it where it stays below."""
    share = 0.3
    for _ in range(2):
        left = lab.left(nominal, lambda rig, share=share: add(rig, share), lab.setting.points, linear=True)
        share = float(np.clip(share * sigmas / max(np.linalg.norm(left), 1e-3), 1e-3, 1.0))
    return share


def plain_setting(bench, fits):
    """A setting with all sensors, white noise, and points between the lowest and the highest usual pressure."""
    noise = Noise(1.0, WHITE, 0.0, 0.0, stated=False)
    if bench == VALVE:
        points = [Point("fit", 1e6 * gauge + AMBIENT, 287.0, 50e-3) for gauge in np.linspace(0.2, 0.7, fits)]
        return Setting(bench, "chambers", tuple(points), noise, 501, 5e-3)
    points = [Point("fit", 1e6 * gauge + AMBIENT, 287.0, speed=800.0 * RPM) for gauge in np.linspace(0.8, 1.0, fits)]
    return Setting(bench, "all", tuple(points), noise, 360, 0.0)


def record(setting, point, found):
    """A run as it is written: grid [SI], channels [SI], and what measured.toml says of it."""
    channels = {name: values for name, values in found.items() if name not in MEANS}
    about = {"supply": f"{1e-6 * (point.supply - AMBIENT):.6g} MPa gauge", "temperature": f"{point.temperature:g} K"}
    if setting.bench == ENGINE:
        about |= {"speed": f"{point.speed / RPM:g} rpm", "energise": "-5 deg", "release": "70 deg"}
        about |= {name: f"{found[name]:.8g} {UNITS[name]}" for name in MEANS if name in found}
    else:
        about["pulse"] = f"{1e3 * point.pulse:g} ms"
    return {"grid": setting.grid(point), "channels": channels, "about": about}


def examine_folder(machine, runs, bench):
    """Write a folder, read it, and check it: its findings, and the number of its runs."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        (path / "machine.toml").write_text(machine)
        lines = [f'bench = "{bench}"']
        for number, run in enumerate(runs, 1):
            heads = [f"{name} [{UNITS.get(name, 'Pa abs')}]" for name in run["channels"]]
            table = np.column_stack([run["grid"], *run["channels"].values()])
            header = ",".join([AXES[bench], *heads])
            np.savetxt(path / f"run{number}.csv", table, "%.8g", ",", header=header, comments="")
            lines += ["[[run]]", f'data = "run{number}.csv"']
            lines += [f'{key} = "{value}"' for key, value in run["about"].items()]
        (path / "measured.toml").write_text("\n".join(lines))
        return examine(Machine.load(path / "machine.toml"), read_measured(path)).findings, len(runs)


def break_folders(rng, bench):
    """What is wrong, and how often it was refused for it, refused otherwise, warned of and passed over in silence."""
    folders = []
    for _ in range(BROKEN_RIGS[bench]):
        nominal, setting = nominal_rig(rng, bench), plain_setting(bench, fits=3 if bench == VALVE else 2)
        lab = Laboratory(setting)
        nuisances = nuisances_for(bench, setting.channels)
        values, runs = drawn(nuisances, rng), []
        for point in setting.points:
            rig = with_nuisances(at_point(nominal, point), nuisances, values)
            run = lab.run(rig, point)
            one = record(setting, point, noisy(setting, point, lab.read(rig, point, run), rng))
            if bench == VALVE:
                warmth = run.states(np.maximum(one["grid"], 0.0))[TEMPERATURE_A]
                one["channels"]["temperature_a"] = warmth + TEMPERATURE_NOISE * rng.normal(size=len(warmth))
            runs.append(one)
        folders.append((machine_file(bench, nominal), runs))
    for what, (change, reason) in WAYS[bench].items():
        judged = Counter()
        for machine, runs in folders:
            changed = [
                change(one | {"channels": dict(one["channels"]), "about": dict(one["about"])}, rng) for one in runs
            ]
            if what.startswith("one file"):
                changed = [runs[0], {**runs[1], **{key: runs[0][key] for key in ("grid", "channels")}}, *runs[2:]]
            judged[judge(examine_folder(machine, changed, bench)[0], reason)] += 1
        yield what, [judged[name] for name in ("right", "otherwise", "warned", "silent")]


def judge(findings: list[Finding], reason: str) -> str:
    """What the findings of a broken folder come to; the reason stands in a finding's text."""
    faults = [one for one in findings if one.kind == Kind.FAULT]
    if any(reason in f"{one.check} {one.reason}" for one in faults):
        return "right"
    if faults:
        return "otherwise"
    return "warned" if any(one.kind == Kind.WARNING for one in findings) else "silent"


# --- ways to break data ---


def on(*names, change):
    """A change of some channels."""

    def changed(run, rng):
        for name in names:
            run["channels"][name] = change(run["channels"][name].copy(), rng)
        return run

    return changed


def shifted(run, _, by):
    """A record whose times stand too late by some time."""
    return run | {"grid": run["grid"] + by}


def spiked(values, rng):
    """One sample of a hundred somewhere else."""
    places = rng.choice(np.arange(5, len(values) - 5), len(values) // 100, replace=False)
    values[places] += rng.choice([-1.0, 1.0], len(places)) * rng.uniform(0.5, 2.0, len(places)) * np.ptp(values)
    return values


def held(values, rng):
    """A third of the record at its last value."""
    first = int(rng.integers(len(values) // 4, len(values) // 2))
    values[first : first + len(values) // 3] = values[first]
    return values


def cut(values, _):
    """No value above three quarters of the span."""
    return np.minimum(values, values.min() + 0.75 * np.ptp(values))


def still(values, rng):
    """Noise about the first value."""
    return values[0] + np.std(np.diff(values[:20])) / np.sqrt(2.0) * rng.normal(size=len(values))


def without_rows(run, _):
    """A record without the rows of ten milliseconds."""
    kept = (run["grid"] < 20e-3) | (run["grid"] > 30e-3)
    return run | {"grid": run["grid"][kept], "channels": {name: each[kept] for name, each in run["channels"].items()}}


def swapped(run, _):
    """Chambers under each other's name."""
    channels = run["channels"]
    return run | {"channels": channels | {"pressure_a": channels["pressure_b"], "pressure_b": channels["pressure_a"]}}


def stating(key, change):
    """A run about which something else is said."""
    return lambda run, _: run | {"about": run["about"] | {key: change(run["about"][key])}}


def in_number(change):
    """A change of the number of a quantity."""

    def changed(text):
        number, _, unit = text.partition(" ")
        return f"{change(float(number)):.8g} {unit}"

    return changed


CHAMBERS = "pressure_a", "pressure_b"
SUITES_OF = {VALVE: ("lift", "chambers"), ENGINE: ("cylinder", "all")}
GAUGE = 1e-6 * AMBIENT
WAYS = {
    VALVE: {
        "gauge called abs": (on(*CHAMBERS, change=lambda p, _: p - AMBIENT), "gauge called abs"),
        "abs called gauge": (on(*CHAMBERS, change=lambda p, _: p + AMBIENT), "abs called gauge"),
        "supply: gauge called abs": (stating("supply", in_number(lambda p: p - GAUGE)), "gauge called abs"),
        "supply: abs called gauge": (stating("supply", in_number(lambda p: p + GAUGE)), "abs called gauge"),
        "µm called mm, or mm called m": (on("lift", change=lambda x, _: 1e3 * x), "µm called mm, or mm called m"),
        "m called mm": (on("lift", change=lambda x, _: 1e-3 * x), "m called mm"),
        "lift turned round": (on("lift", change=lambda x, _: -x), "inverted"),
        "lift from the open stop": (on("lift", change=lambda x, _: STROKE - x), "inverted, measured from the open"),
        "trigger 10 ms late": (lambda run, rng: shifted(run, rng, -10e-3), "ms late"),
        "trigger 10 ms early": (lambda run, rng: shifted(run, rng, 10e-3), "ms early"),
        "times: ms called s": (lambda run, _: run | {"grid": 1e3 * run["grid"]}, "ms called s"),
        "times: s called ms": (lambda run, _: run | {"grid": 1e-3 * run["grid"]}, "s called ms"),
        "pulse: 50 ms called 5 ms": (stating("pulse", in_number(lambda t: 0.1 * t)), "called"),
        "swapped chambers": (swapped, "a and b swapped"),
        "clipped pressure": (on("pressure_b", change=cut), "clipped"),
        "clipped lift": (on("lift", change=cut), "clipped"),
        "lift in steps of 0.5 mm": (on("lift", change=lambda x, _: 0.5e-3 * np.round(x / 0.5e-3)), "quantised"),
        "a third of the lift held": (on("lift", change=held), "stuck"),
        "one file under two names": (lambda run, _: run, "a file copied"),
        "°C called K": (on("temperature_a", change=lambda t, _: t - 273.15), "degC called K"),
        "pressure that never moves": (on("pressure_a", change=still), "never moves"),
        "lift that never moves": (on("lift", change=still), "never moves"),
        "spikes, 1 % of the samples": (on("lift", "pressure_a", change=spiked), "spikes"),
        "gap of 10 ms": (without_rows, "gaps"),
    },
    ENGINE: {
        "gauge called abs": (on("cylinder_pressure", change=lambda p, _: p - AMBIENT), "gauge called abs"),
        "abs called gauge": (on("cylinder_pressure", change=lambda p, _: p + AMBIENT), "abs called gauge"),
        "0 deg at bottom dead centre": (lambda run, _: run | {"grid": run["grid"] + np.pi}, "bottom dead centre"),
        "top dead centre 20 deg off": (lambda run, _: run | {"grid": run["grid"] + np.radians(20.0)}, "deg off"),
        "torque turned round": (stating("torque", in_number(lambda torque: -torque)), "sign turned round"),
        "air flow: per minute called per second": (stating("air_flow", in_number(lambda f: 60.0 * f)), "per minute"),
        "lift turned round": (on("lift", change=lambda x, _: -x), "inverted"),
    },
}
"""What is done to a run by what is wrong, and words of the check or the reason that has to be said."""
