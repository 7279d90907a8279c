"""Nuisances: what is known of a rig only within a prior, and is projected out of everything that is judged.

The priors are standard deviations: those that the user states in ``[known_to]``, and else what a catalogue, a drawing
or a calibration sheet leaves open.
"""

from collections.abc import Iterator, Mapping
from math import isnan
from pathlib import Path
from typing import Any, NamedTuple

from apesim.engine.effects import ALL_EFFECTS
from apesim.engine.machine import Machine
from apesim.engine.stated_uncertainties import (
    GAIN,
    KNOWN_TO,
    OFFSET,
    SECOND_EXHAUST,
    VALVE_IS_OFF,
    find_odd_share,
    format_known_to,
    is_of_absent_valve,
    name_key,
)
from apesim.quantities import Fault, InputError
from apesim.quantities.trees import overruled
from apesim.quantities.uncertainties import Uncertainty
from apesim.studies.estimation.parameters import DECLARED, INSTRUMENTS, Parameter, shown, value_of
from apesim.studies.measured import Measured
from apesim.studies.measured.sensors import FILE
from apesim.studies.measured.stated_uncertainties import matters

DEFAULT, MACHINE_FILE = "default", "machine file"
"""Sources of a prior that measured.toml does not state."""


class Prior(NamedTuple):
    """The standard deviation within which a number of the machine is known."""

    key: str
    """Key of the machine file."""
    deviation: float
    """Standard deviation: a share of the value where it is relative, else SI; 0: the number counts as exact."""
    relative: bool = False
    """Whether the standard deviation is a share of the value."""
    sensor: str = ""
    """Sensor without which the number does not matter; "": it always does."""
    reason: str = ""
    """Why a default has this size; "": the user states it."""
    stated_in: str = DEFAULT
    """Source that states it: a file, or the default."""


MAX_SIGMAS = 100.0
"""Prior standard deviations beyond which no nuisance is fitted."""
GAIN_REASON = "what the calibration of a usual sensor leaves open"
ZERO_REASON = "drift of a pressure sensor's zero, 1 to 5 kPa"
VALVE = (
    Prior("valve.viscous_friction", 0.10, True, reason="seals, grease and temperature move it from day to day"),
    Prior("valve.solenoid.effective_area", 0.05, True, reason="what catalogues and discharge tests leave open"),
    Prior("valve.solenoid.dead_time", 0.1e-3, reason="coil temperature and supply voltage move switching times"),
    Prior("valve.solenoid.release_dead_time", 0.1e-3, reason="as the dead time of energising"),
    Prior("supply.pressure", 0.01, True, reason="a gauge of accuracy class 1 (EN 837-1)"),
    Prior(
        "supply.temperature",
        2.0,
        reason="between the two usual classes of a type K thermocouple, 1.5 and 2.5 K (IEC 60584-1)",
    ),
    Prior(
        "air.heat_capacity_ratio",
        0.003,
        reason="dry air has 1.401 at 300 K, 1.398 at 350 K (NASA polynomials); moisture lowers it, too",
    ),
    Prior("effects.sensor_offset.lift", 0.02e-3, sensor="lift", reason="mounting of the sensor"),
    Prior("effects.sensor_gain.lift", 0.005, sensor="lift", reason=GAIN_REASON),
    Prior("effects.sensor_offset.pressure_a", 2e3, sensor="pressure_a", reason=ZERO_REASON),
    Prior("effects.sensor_gain.pressure_a", 0.005, sensor="pressure_a", reason=GAIN_REASON),
    Prior("effects.sensor_offset.pressure_b", 2e3, sensor="pressure_b", reason=ZERO_REASON),
    Prior("effects.sensor_gain.pressure_b", 0.005, sensor="pressure_b", reason=GAIN_REASON),
)
ENGINE = (
    Prior(
        "groove.effective_area",
        0.03,
        True,
        reason="tolerance of the ports, and what their discharge leaves open",
    ),
    Prior("engine.exhaust.effective_area", 0.05, True, reason="what discharge coefficients of valves leave open"),
    Prior(f"{SECOND_EXHAUST}effective_area", 0.05, True, reason="what discharge coefficients of valves leave open"),
    Prior("engine.receiver.feed_area", 0.05, True, reason="what catalogues and discharge tests leave open"),
    Prior("engine.friction.constant", 2e3, reason="oil temperature moves the friction of an engine"),
    Prior(
        "effects.sensor_offset.cylinder_pressure",
        5e3,
        sensor="cylinder_pressure",
        reason="a piezoelectric sensor has no zero, its level is set by a reference pressure",
    ),
    Prior("effects.sensor_gain.cylinder_pressure", 0.005, sensor="cylinder_pressure", reason=GAIN_REASON),
    Prior(
        "effects.tdc_error.angle",
        0.1 * 3.141592653589793 / 180.0,
        reason="what a capacitive probe at the dead centre leaves open",
    ),
    Prior("effects.sensor_gain.torque", 0.005, sensor="torque", reason="a load cell and the length of its arm"),
    Prior("effects.sensor_gain.air_flow", 0.01, sensor="air_flow", reason="a usual flow meter, 1 % of its reading"),
)
CYLINDER = (
    Prior("rig.bore", 0.05e-3, reason="a bore by a calliper"),
    Prior("rig.viscous_friction", 50.0, reason="half of what the valve's viscous friction is"),
    Prior(
        "effects.sensor_offset.force",
        1.0,
        sensor="force",
        reason="tare of a load cell, with the zero of the pressure sensor (2 kPa on 500 mm2)",
    ),
    Prior("effects.sensor_gain.force", 0.005, sensor="force", reason=GAIN_REASON),
)
BENCH_PRIORS = {"valve": VALVE, "engine": VALVE + ENGINE, "cylinder": CYLINDER}
"""Nuisances of each bench."""


def priors_of(machine: Machine, measured: Measured) -> list[Prior]:
    """What is known of the numbers on which measured data depend, the defaults first, in their order.

    What ``measured.toml`` states goes before what the machine file states, and that before the default; a deviation of
    0 means that the user calls the number exact. Numbers of sensors that the data do not have are left out, and those
    that the machine does not have. Raises InputError where a number is stated that the machine does not have, or of
    which no share can be taken.

    >>> priors = priors_of(Machine(), Measured("", {}, (), "valve"))  # no sensor at all
    >>> priors[0].key, priors[0].deviation, priors[0].stated_in
    ('valve.viscous_friction', 0.1, 'default')
    """
    file = str(Path(measured.folder, FILE))
    stated = {key: (uncertainty, MACHINE_FILE) for key, uncertainty in _useful(machine, measured)}
    stated |= {key: (uncertainty, FILE) for key, uncertainty in measured.known_to.items()}
    if faults := list(_find_faults(machine, measured.known_to, file)):
        raise InputError(faults)
    sensors = {sensor for run in measured.runs for sensor in (*run.channels, *run.means)}
    default = {prior.key: prior for prior in BENCH_PRIORS[measured.bench]}
    known = {key: Prior(key, *pair, _sensor_of(key), stated_in=where) for key, (pair, where) in stated.items()}
    return [
        prior
        for prior in (default | known).values()
        if (not prior.sensor or prior.sensor in sensors) and has_number(machine, prior.key)
    ]


def nuisances_of(machine: Machine, measured: Measured) -> list[Parameter]:
    """The nuisances of measured data: those of its bench, without those of sensors that it does not have.

    Numbers that count as exact are none, see `priors_of`.
    """
    return [nuisance(machine, prior) for prior in priors_of(machine, measured) if prior.deviation]


def describe_priors(machine: Machine, measured: Measured) -> list[dict[str, Any]]:
    """Describe what is known of the numbers on which measured data depend, for tables and JSON.

    Each has ``key`` as ``[known_to]`` has it, ``value`` in ``unit`` (None: the runs state it), ``known_to`` as text,
    ``stated_in`` and ``reason`` ("" where the user states it).
    """
    rows = []
    for prior in priors_of(machine, measured):
        declaration: Any = DECLARED[prior.key]
        rows.append(
            {
                "key": name_key(prior.key),
                "value": None if prior.key in INSTRUMENTS else shown(declaration, value_of(machine, prior.key)),
                "unit": declaration.unit,
                "known_to": format_known_to(prior.key, Uncertainty(prior.deviation, prior.relative)),
                "stated_in": prior.stated_in,
                "reason": prior.reason,
            }
        )
    return rows


def nuisance(machine: Machine, prior: Prior) -> Parameter:
    """A nuisance as a parameter whose x is its shift in prior standard deviations.

    Beforehand x is a standard normal number; its bounds are what the machine file allows, and `MAX_SIGMAS` prior
    standard deviations at most.
    """
    own = value_of(machine, prior.key)
    low, high = DECLARED[prior.key].ends
    unit = prior.deviation * (own if prior.relative else 1.0)
    ends = max((low - own) / unit, -MAX_SIGMAS), min((high - own) / unit, MAX_SIGMAS)
    return Parameter(prior.key, prior.deviation, *ends, own, True, prior.relative, True)


def _useful(machine: Machine, measured: Measured) -> Iterator[tuple[str, Uncertainty]]:
    """What a machine states of numbers that matter on the bench of the data; the rest is for other benches."""
    for key, uncertainty in machine.known_to:
        if matters(key, measured.bench) and not find_idle(machine, key):
            yield key, uncertainty


def has_number(machine: Machine, key: str) -> bool:
    """Whether a machine has a number: it gives it a value, and has the valve that it is of."""
    return not isnan(value_of(machine, key)) and not is_of_absent_valve(machine, key)


def find_idle(machine: Machine, key: str) -> tuple[str, str] | None:
    """Why a number of a machine does nothing, and what to do; None: it does."""
    ignored = dict(overruled(machine))
    if key in ignored:
        return f"is ignored: {ignored[key]}", "leave it out"
    if is_of_absent_valve(machine, key):
        return VALVE_IS_OFF
    effect = key.split(".")[1] if key.startswith("effects.") else ""
    if effect and not key.startswith((GAIN, OFFSET)) and key not in {prior.key for prior in ENGINE}:
        (known,) = (each for each in ALL_EFFECTS if each.name == effect)
        if not known.is_on(getattr(machine.effects, effect)):
            return "is of an effect that is off", f"switch {effect} on in the machine file, or leave it out"
    return None


def _find_faults(machine: Machine, known_to: Mapping[str, Uncertainty], file: str) -> Iterator[Fault]:
    """Faults of what is stated of numbers that the machine does not have, or of which no share can be taken."""
    for key, uncertainty in known_to.items():
        if fault := find_idle(machine, key) or find_odd_share(machine, key, uncertainty):
            yield Fault(file, f"{KNOWN_TO}.{name_key(key)}", *fault)


def _sensor_of(key: str) -> str:
    """Sensor whose gain or offset a key is; "": it is no sensor's."""
    return key.rpartition(".")[2] if key.startswith((GAIN, OFFSET)) else ""
