"""Machines at random, simulated by apesim and by the independent simulator of `tests.truth`."""

from apesim.engine.cylinder import INTAKES
from apesim.engine.machine import Machine
from tests.acceptance.independent_simulator import engine_deviations, random_machine

from .campaign import WITH_COMPILER, Outcome

LONGEST = 300.0
"""That a trial may take [s]: the independent simulator is not compiled."""
MEMORY = WITH_COMPILER


def trial(seed):
    """Hold an operating point against the independent simulator.

    Parameters
    ----------
    seed : int

    Returns
    -------
    Outcome
    """
    machine, rpm = random_machine(seed)
    kind = f"{INTAKES[machine.engine.intake]}, {'with' if machine.effects != Machine().effects else 'without'} effects"
    beyond = engine_deviations(machine, rpm).beyond()
    if beyond:
        return Outcome(f"{kind}: disagrees", True, f"{rpm:.6g} r/min: {beyond}")
    return Outcome(f"{kind}: agrees")
