"""Periodic states from which the runs of an engine are marched, fixed before anything is fitted."""

from collections.abc import Iterable, Sequence

import numpy as np

from apesim.engine.effects import library_of
from apesim.engine.machine import Machine
from apesim.engine.steady import carry_over
from apesim.march.periodic import Known
from apesim.quantities.trees import fields
from apesim.studies.estimation.parameters import Parameter, put
from apesim.studies.measured import ENGINE, MeasuredRun
from apesim.studies.measured.prediction import run_of, start_of, with_value


class Starts:
    """Periodic states near which those of similar machines are found in a few cycles.

    Each depends on the machine of its run alone (see `apesim.studies.measured.prediction.run_of`), and on which effects
    with volumes of gas, and so with states of their own, are on: never on what was marched before. They are found when
    they are first asked for, and remembered.
    """

    def __init__(self, machines: Sequence[Machine], runs: Sequence[MeasuredRun]) -> None:
        self._machines, self._runs = list(machines), list(runs)
        self._known: dict[tuple[int, tuple[str, ...]], tuple[Machine, Known | None]] = {}

    def near(self, number: int, machine: Machine) -> Known | None:
        """Give the start of run `number`, from 0, for a machine similar to the one that is known.

        None on a valve's bench, which starts from rest, and where an engine does not settle to every cycle alike.
        """
        if self._runs[number].bench != ENGINE:
            return None
        key = number, volumes_on(machine)
        if key not in self._known:
            own = with_volumes(self._machines[number], key[1])
            self._known[key] = own, start_of(own, self._runs[number])
        own, known = self._known[key]
        return known if not known or not key[1] else carry_over(known, own, machine)

    def around(self, machines: Sequence[Machine], known: Sequence[Known | None]) -> "Starts":
        """Take the `known` periodic states of the runs' machines for those of machines near them; None: as here."""
        other = Starts(self._machines, self._runs)
        other._known |= self._known
        other._known |= {
            (number, volumes_on(machine)): (machine, one)
            for number, (machine, one) in enumerate(zip(machines, known, strict=True))
            if one
        }
        return other


def starts_at(
    machine: Machine,
    runs: Sequence[MeasuredRun],
    parameters: Sequence[Parameter] = (),
    x: Sequence[float] | np.ndarray = (),
) -> Starts:
    """Fix the starts of runs at given parameters of a machine; without parameters, it counts as it is.

    `parameters` are those that differ from the machine's own, x (p,) their scaled values.
    """
    return Starts([put(run_of(machine, run), parameters, x) for run in runs], runs)


def volumes_on(machine: Machine) -> tuple[str, ...]:
    """Find the names of the effects that are on and add volumes of gas, and with them states."""
    effects = machine.effects
    volumes = [effect for effect in library_of(effects) if effect.volume]
    return tuple(effect.name for effect in volumes if effect.is_on(getattr(effects, effect.name)))


def with_volumes(machine: Machine, names: Iterable[str]) -> Machine:
    """Switch effects that add volumes on and off, so that those of some names are on and no others.

    One that is on already stays as it is; another has its strengths in the middle of their ranges.

    >>> volumes_on(with_volumes(Machine(), ["supply_droop"]))
    ('supply_droop',)
    """
    wanted = set(names)
    for effect in library_of(machine.effects):
        is_on = effect.is_on(getattr(machine.effects, effect.name))
        if not effect.volume or is_on == (effect.name in wanted):
            continue
        declared = fields(effect.parameters)
        for strength in effect.strengths or effect.parameters._fields[:1]:  # type: ignore[attr-defined]
            middle = 0.5 * sum(declared[strength].ends)
            machine = with_value(machine, f"effects.{effect.name}.{strength}", effect.off if is_on else middle)
    return machine
