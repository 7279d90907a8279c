"""Model of an FMU: its variables, its machine as a row of numbers, and the function of a step that is compiled."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.kernel import kernel
from apesim.march.adaptive import (
    FIRST_STEP,
    LAST_ERROR,
    MIN_LAST_ERROR,
    NEXT_STEP,
    STRETCH_END,
    Accuracy,
)
from apesim.quantities.trees import leaves_of
from apesim.valve.supply import Supply

RENEWED = 8.0
"""Time after which the clock of a step begins anew at 0 [s]; chosen: long runs are as exact as short ones."""


class Variable(NamedTuple):
    """Input or output of an FMU."""

    name: str
    """Its name; it says the unit."""
    unit: str
    """SI unit, as FMI spells it; "": none."""
    text: str
    """What it is, in a line."""
    start: float = 0.0
    """Start value of an input."""
    low: float = -np.inf
    """Least value of an input."""
    high: float = np.inf
    """Largest value of an input."""
    is_whole: bool = False
    """Whether it is a whole number."""


class Model(NamedTuple):
    """What an FMU computes."""

    kind: str
    """Either "valve" or "engine"."""
    inputs: Sequence[Variable]
    """Inputs, in the order of the step's."""
    outputs: Sequence[Variable]
    """Outputs, in the order of the step's."""
    numbers_of: Callable[[Machine], Any]
    """Function from a machine to what the step takes of it: a tuple of numbers, arrays and such tuples."""
    state_size: int
    """Length of a state."""
    start_state: np.ndarray
    """State from which a run begins, (state_size,)."""
    make_step: Callable[[Any], Any]
    """Function from such a tuple to the function of a step, to be compiled for its types and shapes."""
    given: Sequence[str] = ("supply.pressure", "supply.temperature", "supply.control_pressure")
    """Keys of the machine that inputs stand for, or that follow them."""
    held: Sequence[str] = ()
    """Beginnings of keys that the state at the start follows, too: they are fixed at export."""


def supply_inputs(pressure: float, temperature: float, what: str) -> tuple[Variable, Variable]:
    """Make the inputs of a supply, with their start values [Pa abs] and [K]; they have the ranges of a machine file."""
    ranges = {key: leaf.declaration for key, leaf in leaves_of(Supply).items()}
    low, high = ranges["pressure"].ends
    coldest, warmest = ranges["temperature"].ends
    return (
        Variable("supply_pressure_Pa", "Pa", f"Pressure of the supply ({what}), absolute", pressure, low, high),
        Variable("supply_temperature_K", "K", f"Temperature of the supply ({what})", temperature, coldest, warmest),
    )


@kernel
def update_carry(carry: np.ndarray, accuracy: Accuracy) -> None:
    """Write what a march carries before its first call into zeros, as `apesim.march.adaptive.begin_carry` does."""
    carry[NEXT_STEP], carry[LAST_ERROR] = FIRST_STEP * accuracy.max_step, MIN_LAST_ERROR
    carry[STRETCH_END] = -np.inf
