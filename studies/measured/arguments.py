"""Arguments of the public functions that compare a machine with measured data."""

from collections.abc import Callable, Iterable
from math import isclose, isnan
from os import PathLike
from typing import Any

from apesim.engine.machine import Machine
from apesim.quantities import Fault, InputError, Quantity
from apesim.studies.execution.calls import arguments_of
from apesim.studies.measured import Measured, read_measured
from apesim.studies.measured.plausibility.impossible import mask_impossible

Tell = Callable[[str, int, int], object]
"""Called with the name of a stage, what is done of it and what there is to do."""


def open_measured(
    function: str,
    machine: Machine,
    measured: Measured | str | PathLike[str],
    *,
    bench: str | None = None,
    faults: Iterable[tuple[str, str, str]] = (),
    **numbers: tuple[Any, Quantity],
) -> tuple[Machine, Measured, dict[str, Any]]:
    """Check the arguments of a public function, and read the measured data where a folder is given.

    `bench` is the only one of "valve", "engine" and "cylinder" that is of use; `faults` are those of further arguments:
    name, what is wrong, what would be right; `numbers` are further arguments, each a value and its declaration. Returns
    the machine with floats for all its numbers, the data with what the machine rules out masked, and the further
    arguments in SI; raises InputError with every fault.
    """
    arguments, machine = arguments_of(function, machine)
    given = {name: arguments.quantity(name, value, declared) for name, (value, declared) in numbers.items()}
    for fault in faults:
        arguments.fault(*fault)
    arguments.refuse()
    if not isinstance(measured, Measured):
        return machine, mask_impossible(machine, read_measured(measured, machine.ambient.pressure, bench)), given
    if not isnan(measured.ambient_pressure) and not isclose(measured.ambient_pressure, machine.ambient.pressure):
        wrong = f"was read with gauge pressures above {measured.ambient_pressure:g} Pa"
        right = f"read it with ambient_pressure={machine.ambient.pressure!r}, as the machine has it"
        raise InputError([Fault(f"{function}()", "measured", wrong, right)])
    if bench and measured.bench != bench:
        wrong, right = f"is of a bench of the {measured.bench}", f"give data of a bench of the {bench}"
        raise InputError([Fault(f"{function}()", "measured", wrong, right)])
    return machine, mask_impossible(machine, measured), given
