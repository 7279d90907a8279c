"""Commands that the page asks for: those with which the valve opens and closes as the ideal one does."""

from apesim.engine.angles import DEGREE
from apesim.engine.cylinder import EPV
from apesim.engine.machine import Machine
from apesim.quantities import Fault, InputError
from apesim.studies.explore.requests import PAGE, Request


def can_correct(machine: Machine) -> bool:
    """Whether one pair of commands is for all valves of a machine."""
    return machine.engine.intake == EPV and not machine.stage_2.is_on and not any(machine.cylinder)


def correct_commands(request: Request) -> dict[str, str]:
    """Find the commands with which the valve meets its targets, as the page has them; raises InputError if none do."""
    from apesim.studies.timing.solve import corrected

    timing = corrected(request.machine, request.speed)
    if not timing.reachable:
        raise InputError([Fault(PAGE, "command.energise", "leads to no such timing", timing.reason.remedy)])
    command = timing.machine.command
    return {
        "command.energise": f"{command.energise / DEGREE:.6g} deg",
        "command.release": f"{command.release / DEGREE:.6g} deg",
    }
