"""A case's folder: ``measured.toml``, a CSV for each run and ``machine.toml``."""

from math import degrees

import numpy as np

from tests.truth.simulator.sensors import MEANS

from .library import ENGINE
from .setting import AMBIENT, RPM

AXES = {"valve": ("time [ms]", 1e3), "engine": ("crank_angle [deg]", degrees(1.0))}
READINGS = {"lift": ("mm", 1e3), "torque": ("N m", 1.0), "air_flow": ("g/s", 1e3)}
PRESSURE = ("kPa", 1e-3)
DIGITS = 8


def reading(name):
    """Unit of a channel, and its factor from SI."""
    return READINGS.get(name, PRESSURE)


def write_case(folder, setting, nominal, runs, stated=()):
    """Write a case's folder.

    Parameters
    ----------
    folder : pathlib.Path
    setting : truth.sealed.setting.Setting
    nominal : truth.simulator.effects.Rig
    runs : sequence of (Point, dict)
        Readings of each run, SI.
    stated : sequence of str
        Lines that say how far the rig is known.
    """
    folder.mkdir(parents=True, exist_ok=True)
    lines = [f'bench = "{setting.bench}"']
    for name in setting.channels if setting.noise.stated else ():
        unit, factor = reading(name)
        lines += [f"[sensor.{name}]", f'noise = "{setting.deviation(name) * factor:.6g} {unit}"']
    lines += stated
    for number, (point, found) in enumerate(runs, 1):
        file = file_of(number)
        write_run(folder / file, setting, point, found)
        lines += ["[[run]]", f'data = "{file}"', *conditions(setting, point)]
        for name in MEANS:
            if name in found:
                unit, factor = reading(name)
                lines.append(f'{name} = "{found[name] * factor:.8g} {unit}"')
    (folder / "measured.toml").write_text("\n".join(lines) + "\n")
    (folder / "machine.toml").write_text(machine_file(setting.bench, nominal))


def file_of(number):
    """Name of a run's file, by its number from 1."""
    return f"run{number:02d}.csv"


def conditions(setting, point):
    """Lines of an operating point."""
    gauge, number = 1e-6 * (point.supply - AMBIENT), setting.points.index(point) + 1
    lines = [f'supply = "{gauge:.4g} MPa gauge"', f'temperature = "{point.temperature:g} K"', f'role = "{point.role}"']
    if point.repeats > 1:
        lines.append(f'name = "point {number}"')
    if setting.bench == ENGINE:
        return [*lines, f'speed = "{point.speed / RPM:g} rpm"', 'energise = "-5 deg"', 'release = "70 deg"']
    return [*lines, f'pulse = "{1e3 * point.pulse:g} ms"']


def write_run(path, setting, point, found):
    """Write a run's traces."""
    header, factor = AXES[setting.bench]
    headers, columns = [header], [setting.grid(point) * factor]
    for name in setting.channels:
        if name in MEANS:
            continue
        unit, factor = reading(name)
        headers.append(f"{name} [{unit}{' abs' * ('pressure' in name)}]")
        columns.append(found[name] * factor)
    np.savetxt(path, np.column_stack(columns), f"%.{DIGITS}g", ",", header=",".join(headers), comments="")


def machine_file(bench, nominal):
    """The nominal machine; the default engine needs no word."""
    if bench == ENGINE:
        return "# The default machine.\n"
    valve = nominal.engine.valve
    return (
        f'[valve]\nviscous_friction = "{valve.viscous_friction:.6g} N s/m"\n'
        f'[valve.solenoid]\neffective_area = "{valve.effective_area * 1e6:.6g} mm^2"\n'
        f'dead_time = "{valve.dead_time * 1e3:.6g} ms"\nramp_time = "{valve.ramp_time * 1e3:.6g} ms"\n'
    )
