"""Design of a machine: a builder's answers, what follows from them, and what is odd about it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from apesim.archive import write_file
from apesim.engine.angles import RPM
from apesim.engine.first_keys import FIRST_KEYS
from apesim.engine.machine import Machine
from apesim.quantities.arguments import Given, WithUnit
from apesim.quantities.printing import OTHERS
from apesim.quantities.settings import differences, dumps, replaced
from apesim.quantities.trees import overruled, schema, with_value
from apesim.restriction import AREA_OF_CONDUCTANCE
from apesim.studies.design.conductance import effective_area_of
from apesim.studies.design.plausibility import find_oddities
from apesim.studies.design.questions import DISCHARGE, QUESTIONS, declarations
from apesim.studies.design.rules import KEPT, RATED_SPEED, Derived, derive
from apesim.studies.drawing.axes import axes_for, in_house_style
from apesim.studies.execution.calls import arguments_of, public
from apesim.studies.execution.output import refuse_to_replace

if TYPE_CHECKING:
    from matplotlib.axes import Axes

EQ_8_RATIO = 0.528
"""Critical pressure ratio of Eq. 8 of the EPV paper (doi 10.1631/jzus.A0820373), where none is answered."""
HEAD = """\
# Made by `apesim new` for a rated speed of {speed:g} r/min. Behind each value: its range; where it comes from.
# "answered": the builder said so; "derived": it follows by the rule that is named; "default": it is the default's.
"""
"""First lines of the file of a machine that was designed."""


@dataclass(frozen=True, eq=False, repr=False)
class MachineDesign:
    """Machine that was made from a builder's answers.

    Attributes
    ----------
    machine : Machine
        The machine, to be run.
    rated_speed : float
        Speed that ports and valve are sized for [rad/s].
    origins : dict of str to str
        Where each number comes from, by key of the machine file: answered, derived (with the rule), default.
    warnings : tuple of str
        What is implausible, with numbers and what to change.
    """

    machine: Machine
    rated_speed: float
    origins: Mapping[str, str]
    warnings: tuple[str, ...]

    def __repr__(self) -> str:
        values, origins = self._values(), self.origins.items()
        answered = [f"  {key} = {values[key]}" for key, text in origins if text.startswith("answered")]
        derived = sum(text.startswith("derived") for text in self.origins.values())
        lines = [f"machine for {self.rated_speed / RPM:g} r/min", *answered, f"  and {derived} keys that follow"]
        return "\n".join([*lines, *(f"warning: {text}" for text in self.warnings)])

    def _repr_html_(self) -> str:
        values = self._values()
        rows = [(key, values[key], text) for key, text in self.origins.items()]
        cells = ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows]
        warned = [f"<div>warning: {escape(text)}</div>" for text in self.warnings]
        caption = f"<caption>machine for {self.rated_speed / RPM:g} r/min</caption>"
        body = "".join(f"<tr>{row}</tr>" for row in cells)
        return f"<table>{caption}<tbody>{body}</tbody></table>{''.join(warned)}"

    def _values(self) -> dict[str, str]:
        """Value of each key in `origins`, as text."""
        leaves = {leaf.key: leaf for leaf in schema(type(self.machine), self.machine)}
        ambient, texts = self.machine.ambient.pressure, dict(differences(self.machine))
        for key in self.origins:
            if key in leaves:
                text = leaves[key].declaration.render(leaves[key].default, ambient)
                texts[key] = text if isinstance(text, str) else "a curve"
        return texts

    def to_dict(self) -> dict[str, Any]:
        """Return the design as data, as ``apesim new --json`` shows it.

        Returns
        -------
        dict
            ``rated_speed_rpm``, ``keys`` (for each key its ``value`` and ``origin``) and ``warnings``.

        Examples
        --------
        >>> import apesim
        >>> apesim.design_machine(bore="60 mm").to_dict()["keys"]["engine.bore"]
        {'value': '60 mm', 'origin': 'answered'}
        """
        values = self._values()
        keys = {key: {"value": values[key], "origin": text} for key, text in self.origins.items()}
        return {"rated_speed_rpm": self.rated_speed / RPM, "keys": keys, "warnings": list(self.warnings)}

    def to_toml(self) -> str:
        """Print the machine as a machine file, each number with where it comes from.

        Returns
        -------
        str
            Text of TOML, which `apesim.Machine.load` reads.

        Examples
        --------
        >>> import apesim
        >>> text = apesim.design_machine(bore="60 mm").to_toml()
        >>> next(line for line in text.splitlines() if line.startswith("bore"))
        'bore = "60 mm" # 5 to 1000 mm; answered'
        """
        return self._text(Path.cwd())

    def _text(self, folder: Path) -> str:
        """Text of the machine file as it stands in a folder, which it names other files from."""
        text = dumps(self.machine, folder, keys=list(self.origins), sources=self.origins)
        return HEAD.format(speed=self.rated_speed / RPM) + text[text.index(f"# {OTHERS}") :]

    def write(self, path: str | PathLike[str], *, overwrite: bool = False) -> Path:
        """Write the machine file.

        Parameters
        ----------
        path : path
            File to write; it is complete or absent.
        overwrite : bool
            Whether one that is there may be replaced.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ArchiveError
            There is one that is not to be replaced, or it cannot be written.

        Examples
        --------
        >>> import tempfile
        >>> import apesim
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = apesim.design_machine(bore="60 mm").write(f"{folder}/mine.toml")
        ...     apesim.Machine.load(path).engine.bore
        0.06
        """
        refuse_to_replace(path, overwrite=overwrite)
        write_file(path, self._text(Path(path).absolute().parent).encode())
        return Path(path)

    @in_house_style
    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the machine to scale, with its dimensions.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; those of a new figure if left out.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Examples
        --------
        >>> import apesim
        >>> apesim.design_machine(bore="60 mm").plot().get_aspect()
        1.0
        """
        from apesim.studies.drawing.machine import draw_engine

        ax = axes_for(ax)
        draw_engine(ax, self.machine)
        return ax


@public
def design_machine(
    machine: Machine | None = None,
    *,
    ambient_pressure: Given | None = None,
    ambient_temperature: Given | None = None,
    supply_pressure: Given | None = None,
    supply_temperature: Given | None = None,
    control_pressure: Given | None = None,
    bore: Given | None = None,
    stroke: Given | None = None,
    compression_ratio: Given | None = None,
    rated_speed: WithUnit | None = None,
    piston_diameter: Given | None = None,
    valve_stroke: Given | None = None,
    conductance: Given | None = None,
    critical_ratio: Given | None = None,
    dead_time: Given | None = None,
    ramp_time: Given | None = None,
    discharge_test: Sequence[str | PathLike[str]] | None = None,
    vessel_volume: Given | None = None,
) -> MachineDesign:
    """Make a machine of one's own from what its builder can answer; the rest follows by rules of proportion.

    The rules scale the default machine: ports with swept volume and rated speed, as in E. g. Heywood's Mach index [1]_,
    the receiver with the swept volume, the valve's mass, springs and clearance with its piston and stroke. What no rule
    is about stays the default machine's. Each number of the result says which of these it is.

    Parameters
    ----------
    machine : Machine, optional
        Where it differs from the default machine, its numbers count as answered.
    ambient_pressure, ambient_temperature : str or float, optional
        State of the surroundings, e.g. "95 kPa abs", "20 degC".
    supply_pressure, supply_temperature : str or float, optional
        State of the supply behind its regulator, e.g. "0.8 MPa gauge".
    control_pressure : str or float, optional
        Pressure of the valve's control air; that of the supply if left out.
    bore, stroke : str or float, optional
        Of the engine's cylinder, e.g. "60 mm".
    compression_ratio : float, optional
        Swept and clearance volume over clearance volume.
    rated_speed : str, optional
        Speed that ports and valve are sized for, e.g. "1500 rpm".
    piston_diameter, valve_stroke : str or float, optional
        Of the intake valve's piston.
    conductance, critical_ratio : str or float, optional
        C, e.g. "1.8 dm^3/(s bar)", and b of a solenoid valve by ISO 6358 [2]_. They become the effective area that
        fills a chamber in the same time.
    dead_time, ramp_time : str or float, optional
        Of a solenoid, from its signal until it begins to open, and from there until it is open.
    discharge_test : sequence of path, optional
        CSVs of discharge tests of the solenoid valve, see `apesim.evaluate_discharge`; in place of the last four.
    vessel_volume : str or float, optional
        Volume of the vessel that was discharged.

    Returns
    -------
    MachineDesign
        The machine, where its numbers come from, and what is implausible about it.

    Raises
    ------
    InputError
        An answer cannot be used; with every fault.
    NotConverged
        The discharge tests give no curve.

    References
    ----------
    .. [1] J. B. Heywood, "Internal Combustion Engine Fundamentals", McGraw-Hill, 1988, chapter 6.
    .. [2] ISO 6358-1:2013, "Pneumatic fluid power - Determination of flow-rate characteristics of components using
       compressible fluids - Part 1: General rules and test methods for steady-state flow".

    Examples
    --------
    >>> import apesim
    >>> design = apesim.design_machine(bore="60 mm", stroke="60 mm", rated_speed="1500 rpm")
    >>> design.machine.engine.receiver.volume, design.origins["engine.receiver.volume"]
    (0.0003397, 'derived: 2.00 swept volumes, at most 1 m3 (chosen)')
    """
    answers = {
        "ambient_pressure": ambient_pressure,
        "ambient_temperature": ambient_temperature,
        "supply_pressure": supply_pressure,
        "supply_temperature": supply_temperature,
        "control_pressure": control_pressure,
        "bore": bore,
        "stroke": stroke,
        "compression_ratio": compression_ratio,
        "rated_speed": rated_speed,
        "piston_diameter": piston_diameter,
        "valve_stroke": valve_stroke,
        "conductance": conductance,
        "critical_ratio": critical_ratio,
        "dead_time": dead_time,
        "ramp_time": ramp_time,
        "vessel_volume": vessel_volume,
    }
    arguments, machine = arguments_of("design_machine", Machine() if machine is None else machine)
    base_keys = {key: "answered" for key, _ in differences(machine)}

    # The answers in SI. Gauge pressures stand above the answered surroundings, those of the machine move with them.
    surroundings = arguments.quantity("ambient_pressure", ambient_pressure, declarations()["ambient_pressure"])
    arguments.refuse()
    if surroundings is not None:
        machine = machine.with_(**{"ambient.pressure": surroundings})
        arguments.ambient_pressure = machine.ambient.pressure
    values = {name: arguments.quantity(name, given, declarations()[name]) for name, given in answers.items()}
    _check_discharge(arguments, values, discharge_test)
    arguments.refuse()

    # What was answered, put into the machine.
    given = dict(base_keys)
    for question in QUESTIONS:
        value = values.get(question.name)
        if question.key and value is not None and question.name != "conductance":
            if question.name == "piston_diameter":
                value = _area_of(value)
                given[question.key] = f"answered: a diameter of {1e3 * values['piston_diameter']:g} mm"
            else:
                given[question.key] = "answered"
            machine = with_value(machine, question.key, value)
    speed = RATED_SPEED if values["rated_speed"] is None else values["rated_speed"]
    if discharge_test:
        machine, curve = _with_discharge(machine, discharge_test, values["vessel_volume"])
        given |= curve

    # What follows, and the solenoid of ISO 6358 last: a C that is left out is that of the valve which the rules give.
    machine, derived = derive(machine, speed, frozenset(given))
    if values["conductance"] is not None or values["critical_ratio"] is not None:
        machine, origin = _with_conductance(machine, values)
        derived = [row for row in derived if row.key != "valve.solenoid.effective_area"]
        given["valve.solenoid.effective_area"] = origin
    warnings = [_clipped(row) for row in derived if row.is_clipped] + find_oddities(machine, speed)
    whole = replaced(machine, {}, "design_machine()")  # what does not go together is refused
    return MachineDesign(whole, float(speed), _origins(whole, given, derived), tuple(warnings))


def _check_discharge(arguments: Any, values: Mapping[str, Any], tests: Sequence[Any] | None) -> None:
    """Note what is wrong with the answers about discharge tests, one beside the other."""
    if tests and values["vessel_volume"] is None and not arguments.faults:
        arguments.fault("vessel_volume", "is not answered beside discharge_test", 'write e.g. "500 cm^3"')
    for name in ("conductance", "critical_ratio", "dead_time", "ramp_time"):
        if tests and values[name] is not None:
            arguments.fault(name, "is answered beside discharge_test, which tells it", "give one of them")
    if not tests and values["vessel_volume"] is not None:
        arguments.fault(DISCHARGE[1].name, "is answered without discharge_test", "give the CSV of a test, too")


def _area_of(diameter: float) -> float:
    """Area of the valve's piston by its diameter, as the machine file has it."""
    return type(Machine().valve).spellings()["piston_diameter"].convert(diameter)


def _with_discharge(machine: Machine, tests: Sequence[Any], volume: float) -> tuple[Machine, dict[str, str]]:
    """Give a machine the solenoid that discharge tests tell: effective area and opening curve."""
    from apesim.results import NotConverged
    from apesim.studies.discharge.effective_area import evaluate_discharge

    area = evaluate_discharge(machine, list(tests), volume=volume)
    if area.evaluation.refusal:
        wrong, _, right = area.evaluation.refusal.partition("? ")
        raise NotConverged("discharge tests", f"{wrong}?", right, area)
    curve = area.evaluation.curve[:, :2]
    found = machine.with_(
        valve_solenoid_effective_area=f"{area['effective_area_mm2']:.4g} mm^2", valve_solenoid_opening_curve=curve
    )
    origin = f"answered: by discharge tests of {1e6 * volume:g} cm3"
    return found, {"valve.solenoid.effective_area": origin, "valve.solenoid.opening_curve": origin}


def _with_conductance(machine: Machine, values: Mapping[str, Any]) -> tuple[Machine, str]:
    """Give a machine the solenoid of a sonic conductance and a critical ratio, and say so."""
    solenoid, control = machine.valve.solenoid, machine.supply.control().pressure
    conductance, critical = values["conductance"], values["critical_ratio"]
    conductance = solenoid.effective_area / AREA_OF_CONDUCTANCE if conductance is None else conductance
    critical = EQ_8_RATIO if critical is None else critical
    area = effective_area_of(conductance, critical, min(machine.ambient.pressure / control, 0.5))
    said = f"answered: C = {1e8 * conductance:.4g} dm3/(s bar), b = {critical:g}; the area that fills in the same time"
    return machine.with_(valve_solenoid_effective_area=f"{1e6 * area:.4g} mm^2"), said


def _clipped(row: Derived) -> str:
    """Warning about a rule that leads out of the range of its key."""
    return f"{row.key} is taken as {row.text}, the end of its range, where its rule leads beyond: {row.rule}"


def _origins(machine: Machine, given: Mapping[str, str], derived: Sequence[Derived]) -> dict[str, str]:
    """Origins of all numbers, by key, in the order of the machine file; none of keys that others replace."""
    found = dict.fromkeys((*FIRST_KEYS, "valve.solenoid.ramp_time"), "default: not answered")
    found |= {key: f"default: {reason}" for key, reason in KEPT.items()}
    found |= {row.key: f"derived: {row.rule}" for row in derived} | dict(given)
    idle = {key for key, _ in overruled(machine)} - set(given)
    places = {leaf.key: place for place, leaf in enumerate(schema(type(machine)))}

    def place_of(key: str) -> int:
        return places.get(key.split("[")[0], len(places))  # keys of tables and of arrays stand last

    return {key: found[key] for key in sorted(found, key=place_of) if key not in idle}
