"""Parameters that measured data may move: nuisances, which have priors, and strengths of effects, which have none."""

from collections.abc import Iterable, Sequence
from math import isnan
from typing import Any, NamedTuple

from apesim.engine.effects import ALL_EFFECTS
from apesim.engine.machine import Machine
from apesim.quantities.declarations import Declaration
from apesim.quantities.settings import schema
from apesim.quantities.units import unit as unit_of
from apesim.studies.measured import MeasuredRun
from apesim.studies.measured.prediction import with_values


class Parameter(NamedTuple):
    """A parameter that measured data may move, as a scaled number x.

    A parameter of an effect has the value ``origin + scale x``, or ``scale / x`` where it is inverse. A nuisance shifts
    what the machine has by ``scale x``, or by that share of it where it is relative.
    """

    key: str
    """Key of the machine, e.g. "effects.coulomb_friction.force"."""
    scale: float
    """Scale of x: the standard deviation of a prior, or the larger end of an effect's range [SI]."""
    low: float
    """Least x."""
    high: float
    """Largest x."""
    origin: float = 0.0
    """Value at x = 0 [SI]; of a nuisance the machine's own."""
    shifts: bool = False
    """Whether it is a nuisance."""
    relative: bool = False
    """Whether its scale is a share."""
    prior: bool = False
    """Whether x is known beforehand: to one, its standard deviation, see `apesim.studies.estimation.heavy_tails`."""
    inverse: bool = False
    """Whether the value is ``scale / x``, as of an area that does the less the larger it is; off at x = 0."""
    reach: float = 1.0
    """How far beyond what the machine file allows a fit may go: `low` and `high` have it in them."""
    outside: Declaration | None = None
    """How an effect from outside declares it; None: it is of one of ours."""
    is_sensed: bool = False
    """Whether it is of an effect from outside that the sensors alone know."""
    file: str = ""
    """File of the one run that it is of, see `apesim.studies.measured.MeasuredRun.file`; "": it is of all runs."""

    def is_of(self, run: MeasuredRun) -> bool:
        """Whether a run depends on it: it is of all runs, or of this one."""
        return not self.file or self.file == run.file

    @property
    def is_file_number(self) -> bool:
        """Whether it is an error of a number of the machine file that counts as exact."""
        return self.shifts and not self.prior and not self.file

    @property
    def declaration(self) -> Declaration:
        """How the machine file declares it."""
        return self.outside or DECLARED[self.key]

    @property
    def ends(self) -> tuple[float, float]:
        """Least and largest x that a machine file takes."""
        return self.low / self.reach, self.high / self.reach

    @property
    def is_marched(self) -> bool:
        """Whether the march knows of it, not the sensors alone."""
        if self.outside:
            return not self.is_sensed
        return self.key.split(".")[1] not in SENSED if self.key.startswith("effects.") else True

    def value(self, x: float) -> float:
        """The value at x [SI]."""
        if self.inverse:
            return self.scale / float(x) if x > 0.0 else self.origin
        return self.origin + self.scale * float(x) * (self.origin if self.relative else 1.0)

    def shown(self, value: float) -> float:
        """A value [SI] in the unit of the machine file."""
        return shown(self.declaration, value)


SENSED = {effect.name for effect in ALL_EFFECTS if effect.slots == ("sensor",)}
INSTRUMENTS = {
    "supply.pressure": "effects.sensor_gain.supply_pressure",
    "supply.temperature": "effects.sensor_offset.supply_temperature",
}
"""Errors of what runs state of their supply."""
DECLARED = {leaf.key: leaf.declaration for leaf in schema(Machine)}


def shown(declaration: Declaration, value: float) -> float:
    """A value [SI] in the unit in which the machine file declares it."""
    return value / unit_of(declaration.unit).si("1")  # type: ignore[attr-defined]


def value_of(tree: Any, key: str) -> Any:
    """The value that stands in a machine at a key with dots, e.g. "valve.stroke"; SI where it is a quantity.

    Raises AttributeError where there is no such key.
    """
    for name in key.split("."):
        tree = getattr(tree, name)
    return tree


def put(machine: Machine, parameters: Iterable[Parameter], x: Iterable[float]) -> Machine:
    """The machine with parameters set to given x, one for each.

    `machine` has the supply of the run: a share of the supply's pressure is one of that above ambient, as a gauge errs.
    """
    values: dict[str, Any] = {}
    for parameter, number in zip(parameters, x, strict=True):
        key = parameter.key
        if parameter.shifts:
            own = values[key] if key in values else value_of(machine, key)
            zero = values.get("ambient.pressure", machine.ambient.pressure) if key == "supply.pressure" else 0.0
            values[key] = own + parameter.scale * float(number) * (own - zero if parameter.relative else 1.0)
        else:
            values[key] = parameter.value(number)
    return with_values(machine, values)


def corrections(machine: Machine, parameter: Parameter, x: float, runs: Sequence[MeasuredRun]) -> dict[str, float]:
    """The entries of a machine file, SI values by key, that a parameter at x stands for.

    Supply pressure and temperature are stated by the runs themselves: where the fit moves them, the instrument is wrong
    that they were read from, and the entry is its gain or offset. There are two where only some of the runs state their
    temperature: the instrument's offset, then the machine's own number.

    A supply that is 2 % higher than its gauge says:

    >>> supply = Parameter("supply.pressure", 0.01, -5.0, 5.0, shifts=True, relative=True, prior=True)
    >>> gain = corrections(Machine(), supply, 2.0, [])
    >>> {key: round(value, 4) for key, value in gain.items()}
    {'effects.sensor_gain.supply_pressure': -0.0196}
    """
    states = {"supply.pressure": True, "supply.temperature": any(not isnan(run.temperature) for run in runs)}
    found: dict[str, float] = {}
    shift = parameter.scale * float(x)
    if states.get(parameter.key):
        key = INSTRUMENTS[parameter.key]
        own = value_of(machine, key)
        found[key] = (1.0 + own) / (1.0 + shift) - 1.0 if parameter.relative else own - shift
    if not found or (parameter.key == "supply.temperature" and any(isnan(run.temperature) for run in runs)):
        found[parameter.key] = value_at(machine, parameter, x)
    return found


def value_at(machine: Machine, parameter: Parameter, x: float) -> float:
    """The value that the machine has with a parameter at x [SI].

    A relative error of the supply's pressure is taken at the supply that the machine itself states.

    >>> value_at(Machine(), Parameter("effects.side_force.force", 10.0, 0.0, 1.3), 0.3)
    3.0
    """
    return value_of(put(machine, (parameter,), (x,)), parameter.key)
