"""Cases with one wrong number in the machine file: the rig is the default one, and the file errs in one number of it.

Twenty seeds in a row make a block: each number of the valve twice on its bench, each number of the engine once on the
engine. In every second case the rig is off in what no machine file knows exactly, too, see `truth.sealed.nuisances`.
"""

from functools import lru_cache
from math import radians
from typing import NamedTuple

import numpy as np

from tests.truth.simulator.effects import Rig

from .files import write_case
from .library import ENGINE, VALVE
from .nuisances import drawn, with_nuisances
from .observation import Laboratory, noisy
from .setting import AMBIENT, RPM, WHITE, Noise, Point, Setting

MIN_SIGMAS = 10.0
"""What the wrong number does to the data, beyond what uncertain numbers can take on; smaller errors are drawn anew."""
TRIES = 20
"""Sizes that are drawn; the last one stays, however little it does."""
DIGITS = 4
"""Digits of the wrong number, as people write it."""


class Number(NamedTuple):
    """A number of the machine file, and by how much it is wrong at least and at most."""

    key: str
    bench: str
    field: str
    """Name of it in the simulator's valve or engine."""
    unit: str
    """Unit in the machine file."""
    scale: float
    """SI over that unit."""
    ends: tuple = (0.03, 0.20)
    """Shares of it, or in its unit."""
    is_share: bool = True
    place: int | None = None
    """Place in a field of several."""

    def read(self, rig):
        """The number of a rig, in its unit."""
        part = rig.engine.valve if self.bench == VALVE else rig.engine
        value = getattr(part, self.field)
        return (value if self.place is None else value[self.place]) / self.scale

    def put(self, rig, value):
        """A rig with another one, given in its unit."""
        value *= self.scale
        if self.bench == VALVE:
            return rig.valve(**{self.field: value})
        if self.place is not None:
            several = list(getattr(rig.engine, self.field))
            several[self.place] = value
            value = tuple(several)
        return rig.of_engine(**{self.field: value})


DEGREE = radians(1.0)
NUMBERS = (
    # The lift is measured: a stroke that is off by more is refused, as it cannot be that of the rig.
    Number("valve.stroke", VALVE, "stroke", "mm", 1e-3, ends=(0.03, 0.05)),
    Number("valve.piston_area", VALVE, "piston_area", "mm^2", 1e-6),
    Number("valve.clearance_volume", VALVE, "clearance_volume", "mm^3", 1e-9),
    Number("valve.moving_mass", VALVE, "moving_mass", "kg", 1.0),
    Number("valve.spring_rate", VALVE, "spring_rate", "N/m", 1.0),
    Number("valve.solenoid.ramp_time", VALVE, "ramp_time", "ms", 1e-3),
    Number("engine.bore", ENGINE, "bore", "mm", 1e-3),
    Number("engine.stroke", ENGINE, "stroke", "mm", 1e-3),
    Number("engine.rod_length", ENGINE, "rod_length", "mm", 1e-3),
    Number("engine.compression_ratio", ENGINE, "compression_ratio", "", 1.0),
    Number("engine.exhaust.opens", ENGINE, "exhaust", "deg", DEGREE, (5.0, 20.0), is_share=False, place=0),
    Number("engine.exhaust.closes", ENGINE, "exhaust", "deg", DEGREE, (5.0, 20.0), is_share=False, place=1),
    # These data do not show a receiver that is wrong by less: a fifth does three sigmas to them.
    Number("engine.receiver.volume", ENGINE, "receiver_volume", "L", 1e-3, ends=(0.50, 0.90)),
    Number("groove.lap", ENGINE, "lap", "mm", 1e-3, (0.2, 0.5), is_share=False),
)
OF_VALVE, OF_ENGINE = ([number for number in NUMBERS if number.bench == bench] for bench in (VALVE, ENGINE))
BLOCK = (*OF_VALVE, *OF_VALVE, *OF_ENGINE)
"""Numbers that the seeds of a block make wrong, in order."""
QUIET = Noise(1.0, WHITE, 0.0, 0.0, stated=True)
ROLES_AND_GAUGES = (("fit", 0.16), ("fit", 0.3), ("fit", 0.5), ("fit", 0.7), ("gate", 0.4), ("check", 0.6))
"""Runs of the valve: gauge pressure [MPa]."""
GAUGES_AND_SPEEDS = ((0.6, 600.0), (0.8, 900.0), (1.0, 1200.0), (1.0, 600.0))
"""Runs of the engine, all to fit: gauge pressure [MPa], speed [r/min]."""
SETTINGS = {
    VALVE: Setting(
        VALVE,
        "chambers",
        tuple(Point(role, 1e6 * gauge + AMBIENT, 287.0, pulse=0.05) for role, gauge in ROLES_AND_GAUGES),
        QUIET,
        samples=501,
        before=0.0,
    ),
    ENGINE: Setting(
        ENGINE,
        "all",
        tuple(Point("fit", 1e6 * gauge + AMBIENT, 287.0, speed=RPM * speed) for gauge, speed in GAUGES_AND_SPEEDS),
        QUIET,
        samples=360,
        before=0.0,
    ),
}


class WrongNumber(NamedTuple):
    """A case: what the file says of a number of the default rig, and what the rig is off in besides."""

    number: Number
    written: float
    """In the machine file [unit]."""
    sigmas: float
    """What that does to the runs to fit, once all uncertain numbers have been fitted [standard deviations]."""
    nuisances: dict
    """Values by name; none: the rig is as it should be."""
    rng: np.random.Generator
    """Generator of the readings' noise."""

    @property
    def right(self):
        """The number of the rig [unit]."""
        return self.number.read(Rig())

    @property
    def error(self):
        """Size of the error of the file, as text."""
        if self.number.is_share:
            return f"{100.0 * (self.written / self.right - 1.0):+.1f} %"
        return f"{self.written - self.right:+.3g} {self.number.unit}"


@lru_cache
def laboratory(bench):
    """The laboratory of a bench, which keeps the runs of the default rig, and what uncertain numbers do to them."""
    return Laboratory(SETTINGS[bench])


def draw_wrong_number(seed):
    """Draw a case.

    Parameters
    ----------
    seed : int
        Its place in a block of twenty says which number is wrong, and whether the rig is off besides.

    Returns
    -------
    WrongNumber
    """
    rng = np.random.default_rng(seed)
    place = seed % len(BLOCK)
    number, lab = BLOCK[place], laboratory(BLOCK[place].bench)
    fits = [point for point in lab.setting.points if point.role == "fit"]
    for _ in range(TRIES):
        written = draw_written(number, rng)
        # Taken in proportion, as whether it is enough is all that is asked of the size.
        left = lab.left(Rig(), lambda rig, written=written: number.put(rig, written), fits, linear=True)
        sigmas = float(np.linalg.norm(left))
        if sigmas >= MIN_SIGMAS:
            break
    # The first half of a block's numbers of the valve, and every second one of the engine, have a rig without errors.
    is_off = place >= len(OF_VALVE) if number.bench == VALVE else place % 2 == 1
    return WrongNumber(number, written, sigmas, drawn(lab.nuisances, rng) if is_off else {}, rng)


def draw_written(number, rng):
    """A wrong value of a number, with as many digits as people write [its unit]."""
    right = number.read(Rig())
    error = rng.choice([-1.0, 1.0]) * rng.uniform(*number.ends)
    return float(f"{right * (1.0 + error) if number.is_share else right + error:.{DIGITS}g}")


def write_wrong_number(case, folder):
    """Simulate a case's runs and write its folder, the machine file with the wrong number in it.

    Parameters
    ----------
    case : WrongNumber
    folder : pathlib.Path
    """
    lab = laboratory(case.number.bench)

    def changes(rig):
        return with_nuisances(rig, lab.nuisances, case.nuisances) if case.nuisances else rig

    seen = [(point, lab.seen(Rig(), changes, point)) for point in lab.setting.points]
    runs = [(point, noisy(lab.setting, point, channels, case.rng)) for point, channels in seen]
    write_case(folder, lab.setting, Rig(), runs)
    text = f"{case.written:g} {case.number.unit}".strip()
    (folder / "machine.toml").write_text(f'# The default machine but for one number.\n{case.number.key} = "{text}"\n')
