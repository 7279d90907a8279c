"""Short marches that compile what a run needs, so that what is timed after them is compiled."""

from apesim.engine.drivetrain.preparing import prepare
from apesim.engine.drivetrain.run import run_drivetrain
from apesim.engine.machine import Machine
from apesim.engine.steady import is_of_one_cylinder, run_steady
from apesim.studies.execution.calls import compile_first

QUICK = 100.0
"""Speed of a march that only compiles [rad/s]: a cycle of a slow machine can take seconds of computing."""


def compile_drivetrain(machine: Machine) -> None:
    """Compile the march of a machine's drivetrain."""
    compile_first(machine, march_shortly)


def compile_point(machine: Machine, is_free: bool = False) -> None:
    """Compile the march to a periodic state: of one cylinder at constant speed, or of a drivetrain."""
    if is_free or not is_of_one_cylinder(machine):
        compile_drivetrain(machine)
    else:
        compile_first(machine, run_steady, QUICK, max_cycles=1)


def march_shortly(machine: Machine) -> None:
    """March a drivetrain from rest for an instant."""
    run_drivetrain(prepare(machine, 0.5), 1e-5)
