"""Crank angles at which the intake's valve is to open and close."""

from apesim.engine.angles import DEGREE
from apesim.engine.cylinder import EPV, INTAKES
from apesim.engine.machine import Machine
from apesim.quantities import Culprit, InputError, Quantity, parse_range
from apesim.studies.console import COMMAND_LINE

ANGLE = Quantity("deg", -360, 720, "command line", typical="70 deg")


def require_epv(machine: Machine) -> None:
    """Raise `InputError` where the intake is no electro-pneumatic valve, whose commands could be corrected."""
    if machine.engine.intake != EPV:
        name = INTAKES[machine.engine.intake]
        wrong = f"is {name}, which has no commands to correct"
        raise InputError([Culprit(COMMAND_LINE, "engine.intake", wrong, 'write "epv"')])


def with_targets(machine: Machine, target: str | None) -> Machine:
    """A machine with the targets of its valve as text, such as ``-5 deg, 70 deg``; its own where that is None.

    Raises
    ------
    InputError
    """
    require_epv(machine)
    if target is None:
        return machine
    angles = parse_range(target, ANGLE, where="--target", file=COMMAND_LINE)
    form = 'write two angles, opening and closing, less than a turn apart, e.g. "-5 deg, 70 deg"'
    if len(angles) != 2:
        raise InputError([Culprit(COMMAND_LINE, "--target", f"{target!r} is not an opening and a closing", form)])
    machine = machine._replace(command=machine.command._replace(open_target=angles[0], close_target=angles[1]))
    faults = [Culprit(COMMAND_LINE, "--target", wrong, form) for _, wrong, _ in machine.command.faults()]
    if angles[0] > 360.0 * DEGREE:
        faults.append(Culprit(COMMAND_LINE, "--target", "opens after more than a turn", form))
    if faults:
        raise InputError(faults)
    return machine
