"""Machines at random, simulated by apesim and by the independent simulator of `tests.truth`."""

from apesim.engine.cylinder import INTAKES
from apesim.engine.machine import Machine
from tests.acceptance.independent_simulator import engine_deviations, random_machine

from .campaign import Outcome

LONGEST = 300.0
"""That a trial may take [s]: the independent simulator is not compiled."""
MEMORY = 2_000_000_000
"""That a process may hold at once during a trial [bytes]; 1.2 GB are what the compiler leaves behind."""


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
