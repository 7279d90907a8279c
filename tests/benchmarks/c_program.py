"""The bench in C, `bench_march.c`: the same equations by the same method, with nothing around them."""

import json
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

from apesim.engine.machine import Machine
from apesim.valve.actuator import MAX_STEP

SOURCE = Path(__file__).with_name("bench_march.c")
COMPILER = shutil.which("gcc")
FLAGS = ("-std=gnu17", "-O3", "-march=native")
"""All that keeps to IEEE 754: no fast-math, as with the kernels."""
REPEATS = 2000


class Marched(NamedTuple):
    """A march in C."""

    seconds: float
    """Shortest time [s]."""
    evaluations: int
    """Number of evaluations of the rates."""
    contacts: list[float]
    """Times of contact [s]."""


class CProgram:
    """The program, compiled into a folder."""

    def __init__(self, folder):
        self.program = Path(folder) / "bench_march"
        subprocess.run([COMPILER, *FLAGS, "-o", self.program, SOURCE, "-lm"], check=True)

    def run(self, pulse, end, tolerance, repeats=REPEATS):
        """March the default machine's bench so many times."""
        numbers = [repr(float(number)) for number in (*_machine(), pulse, end, tolerance, MAX_STEP)]
        done = subprocess.run([self.program, *numbers, str(repeats)], capture_output=True, check=True)
        found = json.loads(done.stdout)
        return Marched(found["seconds"], found["evaluations"], found["contacts"])


def _machine():
    """The default machine's numbers, in the order of `struct machine`."""
    machine = Machine()
    valve, air = machine.valve, machine.air
    yield from (valve.stroke, valve.moving_mass, valve.piston_area, valve.clearance_volume, valve.spring_rate)
    yield valve.viscous_friction
    yield from (valve.solenoid.effective_area, valve.solenoid.dead_time, valve.solenoid.ramp_time, machine.groove.lap)
    yield from (*machine.supply.control(), *machine.ambient, air.gas_constant, air.heat_capacity_ratio)
