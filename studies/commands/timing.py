"""Command `apesim engine timing`."""

from math import isnan
from pathlib import Path

from apesim.archive import ArchiveError
from apesim.engine.angles import DEGREE
from apesim.engine.cylinder import EPV, INTAKES
from apesim.quantities import Culprit, InputError, Quantity, parse_range
from apesim.studies.commands.archived import computed, summary
from apesim.studies.commands.given import SPEED, supplies_of
from apesim.studies.commands.machine import load_machine
from apesim.studies.commands.tables import number, table_of
from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.output import refuse_to_replace

FAR_OFF = 1.0 * DEGREE
"""A law over all speeds that is off by more is not worth telling [rad]."""
ANGLE = Quantity("deg", -360, 720, "command line", typical="70 deg")
SHOWN = (
    ("speed_rpm", 1.0, 0, "speed\n[r/min]"),
    ("supply_pressure", 1e-6, 2, "supply\n[MPa gauge]"),
    ("supply_temperature", 1.0, 0, "\n[K]"),
    ("advance_deg", 1.0, 2, "advance\n[deg]"),
    ("release_advance_deg", 1.0, 2, "release\n[deg]"),
    ("peak_lift_m", 1e3, 2, "lift\n[mm]"),
    ("brake_torque_Nm", 1.0, 2, "torque\n[N m]"),
    ("uncorrected_brake_torque_Nm", 1.0, 2, "before\n[N m]"),
    ("specific_air_kg_per_kWh", 1.0, 1, "air\n[kg/kWh]"),
    ("uncorrected_specific_air_kg_per_kWh", 1.0, 1, "before\n[kg/kWh]"),
    ("shortcut_open_error_deg", 1.0, 2, "opens\n[deg]"),
    ("shortcut_close_error_deg", 1.0, 2, "closes\n[deg]"),
)
LEGEND = (
    "advance of energising and of release; peak lift; brake torque, and all air over brake work, corrected and before; "
    "how late the valve opens and closes if the delays of the bench are subtracted"
)


def machine_with_targets(machine_file, settings, target):
    """The machine of a command line, its intake an electro-pneumatic valve, with targets as text or its own.

    Raises
    ------
    InputError
    """
    machine = load_machine(machine_file, settings)
    if machine.engine.intake != EPV:
        name = INTAKES[machine.engine.intake]
        wrong = f"is {name}, which has no commands to correct"
        raise InputError([Culprit(COMMAND_LINE, "engine.intake", wrong, 'write "epv"')])
    if target is None:
        return machine
    angles = parse_range(target, ANGLE, where="--target", file=COMMAND_LINE)
    form = 'write two angles, opening and closing, less than a turn apart, e.g. "-5 deg, 70 deg"'
    if len(angles) != 2:
        raise InputError([Culprit(COMMAND_LINE, "--target", f"{target!r} is not an opening and a closing", form)])
    machine = machine._replace(command=machine.command._replace(open_target=angles[0], close_target=angles[1]))
    faults = [Culprit(COMMAND_LINE, "--target", wrong, form) for _, wrong, _ in machine.command.faults()]
    if angles[0] > 360.0 * DEGREE:
        faults.append(Culprit(COMMAND_LINE, "--target", "opens after more than a turn", form))
    if faults:
        raise InputError(faults)
    return machine


def timing_command(
    console, machine_file, settings, target, speed, pressure, temperature, out, jobs, overwrite, figures
):
    """Corrected commands over a grid; see `apesim engine timing --help`.

    Returns
    -------
    int
        Exit code.
    """
    from apesim.studies.figures.timing import timing_figures
    from apesim.studies.timing.export import as_json, export, exports_of
    from apesim.studies.timing.grid import faults_of_timing, map_timing
    from apesim.studies.timing.header import error_text
    from apesim.studies.timing.solve import corrected
    from apesim.studies.timing.table import Axes

    machine = machine_with_targets(machine_file, settings, target)
    speeds = parse_range(speed, SPEED, where="--speed", file=COMMAND_LINE)
    axes = Axes(speeds, *supplies_of(machine, pressure, temperature))
    out = Path(out)
    if out in exports_of(out):
        raise ArchiveError(out, "is the name of an export beside the archive", "choose e.g. --out timing.h5")
    if not overwrite:
        for path in exports_of(out):
            refuse_to_replace(path)
    maps = []

    def compute(command, report):
        maps.append(map_timing(machine, axes, jobs, command=command, report=report))
        return maps[0].archive

    def draw(archive, folder):
        return timing_figures(maps[0], machine.ambient.pressure, folder) if figures else []

    _, told = computed(console, "timing", (corrected, machine, speeds[0]), compute, out, overwrite, draw)
    (found,) = maps
    exported = export(found, out)
    faults = faults_of_timing(found.archive)
    data = as_json(found) | told | {"exports": [str(path) for path in exported], "faults": faults}
    where = summary(told, f"{len(data['points'])} points") + "; " + ", ".join(path.name for path in exported)
    opening, closing = data["target_deg"].values()
    title = f"Commands that open the valve at {opening:g} deg and close it at {closing:g} deg"
    header = [*(name for *_, name in SHOWN), "out of reach"]
    table = table_of(title, header, _rows(found.archive, machine.ambient.pressure), left=(len(SHOWN),))
    error = f"error of the interpolated table: {error_text(found.error)}"
    console.result(data, table, LEGEND, *_law_lines(found.laws, machine), error, where)
    for fault in faults:
        console.message(f"warning: {fault}")
    return INCOMPLETE if faults else DONE


def _rows(archive, ambient_pressure):
    v = {name: variable.values for name, variable in archive.variables.items()}
    v["supply_pressure"] = v["supply_pressure"] - ambient_pressure
    columns = [(v[name] * factor, digits) for name, factor, digits, _ in SHOWN]
    return [
        [*(number(values[run], f".{digits}f") for values, digits in columns), _why_not(v["reason"][run])]
        for run in range(len(archive.runs))
    ]


def _why_not(code):
    from apesim.studies.timing.solve import Reason

    reason = Reason(code)
    return "" if reason == Reason.REACHED else reason.words


def _law_lines(laws, machine):
    """The laws of each pressure in words: that over all speeds, or where it is far off, the span of those of each."""
    lines = []
    for name, found in laws.items():
        for pressure in sorted({law.pressure for law in found}):
            here = [law for law in found if law.pressure == pressure]
            over_all = [law for law in here if isnan(law.speed)]
            each = [law for law in here if not isnan(law.speed)]
            far = [law for law in over_all if law.angle_error_most > FAR_OFF]
            told = each if far else over_all or each
            gauge = (pressure - machine.ambient.pressure) / 1e6
            lines.append(f"{name.replace('_', ' ')} at {gauge:.3g} MPa gauge{_law_text(told, far)}")
    return lines


def _law_text(told, far):
    """Laws of one pressure in words, with the one over all speeds that is far off, if there is one."""
    against = sum(law.opposite_to_the_paper for law in told)
    at = f" at {against} of {len(told)} speeds" if 0 < against < len(told) else ""
    sign = f"falls with T_0{at}, against the paper" if against else "rises with T_0, as in the paper"
    times, slopes, errors, angles = (
        [factor * getattr(law, name) for law in told]
        for name, factor in (
            ("at_reference", 1e3),
            ("slope", 1e6),
            ("error_most", 1e3),
            ("angle_error_most", 1.0 / DEGREE),
        )
    )
    scope = f", a law for each speed (one for all is off by {far[0].angle_error_most / DEGREE:.2g} deg)" if far else ""
    return (
        f"{scope}: {_span(times, '.3f')} ms {_span(slopes, '+.2f')} us/K (T_0 - 287 K), off by at most "
        f"{_span(errors, '.3f')} ms or {_span(angles, '.2f')} deg; it {sign}"
    )


def _span(values, form):
    low, high = (f"{end:{form}}" for end in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"
