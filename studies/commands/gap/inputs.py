"""What the commands of the missing effect read and march first: the machine, the measured data, one run of them."""

from collections.abc import Sequence
from os import PathLike

from apesim.engine.machine import Machine
from apesim.engine.outside_machine import outside_effects_of, switched_on
from apesim.quantities import Fault, InputError
from apesim.studies.commands.options import Common
from apesim.studies.gap.input_checks import check_roles
from apesim.studies.gap.search.library import find_faults
from apesim.studies.measured import Measured, read_measured
from apesim.studies.measured.prediction import predict, run_of, with_value
from apesim.studies.terminal.console import COMMAND_LINE, Console


def read_inputs(common: Common, folder: str | PathLike[str], without: Sequence[str]) -> tuple[Machine, Measured]:
    """Read machine and measured data of a command; what cannot be used is refused before anything is compiled.

    `without` names effects that are not to be considered; the InputError for an unknown effect or an unusable file
    names every fault.
    """
    machine = common.load_machine()
    faults = find_faults(without, machine)
    if faults:
        raise InputError([Fault(COMMAND_LINE, f"--{name}", wrong, right) for name, wrong, right in faults])
    measured = read_measured(folder, machine.ambient.pressure)
    common.console.notes(measured.hints)
    check_roles(measured)
    return machine, measured


def compile_march(console: Console, machine: Machine, measured: Measured) -> None:
    """Simulate the first run, as it is, with an effect and with a table, so that what comes after it is compiled.

    The console says that something is compiled.
    """
    run = measured.runs[0]
    nominal = run_of(machine, run)

    def march() -> None:
        predict(nominal, run)
        for key in ("effects.side_force.force", "effects.tabulated_force.force_at_50"):
            predict(with_value(nominal, key, 1.0), run)
        for effect in outside_effects_of(machine):
            predict(switched_on(nominal, effect), run)

    console.warm_up(march)
