"""The machine of an archive on its page: what departs from the default, what is assumed, and the whole text."""

from apesim.air import THERMALLY_PERFECT
from apesim.archive import Archive
from apesim.archive.comparison import machine_differences
from apesim.engine.effects import library_of
from apesim.engine.indicators import is_adiabatic
from apesim.engine.kinematics import swept_volume
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.quantities.settings import dumps
from apesim.studies.archives.machines import read_recorded_machine
from apesim.studies.drawing.conditions import UNNAMED
from apesim.studies.report.sections import Table
from apesim.studies.run.engine_run import supply_conditions

MAX_VALUE = 80
"""Letters of a value that is written out; a longer one is a table or a curve, which is in the whole text."""


SIZES = {
    "engine": ("bore", "stroke", "cylinders"),
    "supply": ("pressure", "temperature", "control"),
    "ambient": ("pressure",),
}
"""Keys that the head of a page names, by their sections."""


def read_machine(archive: Archive) -> Machine:
    """Read the machine of an archive; the default one where its text is none."""
    try:
        return read_recorded_machine(archive.machine)
    except InputError:
        return Machine()


def describe_machine(archive: Archive, kind: str) -> str:
    """Say in a sentence which engine an archive is of; what was varied is left out, "" for a valve on its bench."""
    if not archive.machine or not kind.startswith("engine"):
        return ""
    machine = read_machine(archive)
    engine, count = machine.engine, int(machine.engine.cylinders)
    of_each = f"{count} cylinders, each " if count > 1 else "Engine of "
    phrases = {
        "engine": f"{of_each}{swept_volume(engine) * 1e6:.4g} cm³ "
        f"(bore {engine.bore * 1e3:.4g} mm, stroke {engine.stroke * 1e3:.4g} mm)",
        "supply": f"supply {supply_conditions(machine)['supply']}",
        "ambient": f"surroundings {machine.ambient.pressure / 1e3:.5g} kPa abs",
    }
    varied = [name for name, variable in archive.variables.items() if len(variable.dims) == 1]
    said = [
        text
        for section, text in phrases.items()
        if not any(name.startswith(f"{section}_{key}") for name in varied for key in SIZES[section])
    ]
    return f"{'; '.join(said)}." if said else ""


def list_departures(text: str) -> Table | None:
    """List the keys in which a machine departs from the default one; None where it cannot be compared."""
    if not text:
        return None
    try:
        rows = machine_differences(dumps(Machine()), text)
    except ValueError:
        return None
    shown = [(row.name, _in_short(row.b), _in_short(row.a)) for row in rows if row.name not in UNNAMED]
    return Table("", ("key", "this machine", "default"), shown, is_prose=True)


def _in_short(value: object) -> str:
    """A value of a machine file in words."""
    text = "not given" if value is None else str(value)
    return text if len(text) <= MAX_VALUE else "a table of its own, see the machine file"


def list_assumptions(text: str) -> list[str]:
    """Say what the model of a machine assumes, as sentences; none where the text is no machine."""
    try:
        machine = read_recorded_machine(text) if text else None
    except InputError:
        machine = None
    if machine is None:
        return []
    adiabatic = (
        "Adiabatic: no wall gives heat to the air of the cylinder. The cold temperatures are a limit: real air does "
        "not become so cold."
        if is_adiabatic(machine)
        else "Heat from the walls: an effect brings it to the air of the cylinder, see the machine."
    )
    air = (
        "Air is an ideal gas whose heat capacity changes with its temperature."
        if machine.air.model == THERMALLY_PERFECT
        else "Air is an ideal gas with constant heat capacities."
    )
    on = [
        effect.name.replace("_", " ")
        for effect in library_of(machine.effects)
        if effect.is_on(getattr(machine.effects, effect.name))
    ]
    effects = (
        f"Effects beyond the base model: {', '.join(on)}."
        if on
        else ("No effect beyond the base model is on: no leakage, no wall heat, no sensor error.")
    )
    zones = "Each volume is one zone of uniform pressure and temperature; flow through an opening is quasi-steady."
    return [adiabatic, air, zones, effects]
