"""How far the model is off besides what is named: what the user allows, and what the best explanation leaves."""

from typing import Any

from apesim.quantities.units import unit as unit_of
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.noise.discrepancy import list_discrepancies
from apesim.studies.gap.decide.left import find_left
from apesim.studies.measured.sensors import SENSORS


def describe_discrepancy(model: Model) -> dict[str, dict[str, Any]]:
    """How far the user lets the model be off, by channel: ``value`` in ``unit``; {} where nothing is stated."""
    return _in_units(model, list_discrepancies(model.residuals.noise))


def describe_left(model: Model) -> dict[str, dict[str, Any]]:
    """What a model leaves of each channel, noise averaged out: ``value`` in ``unit``.

    See `find_left`.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> left = describe_left(explain_example().calibrated)["lift"]
    >>> left["unit"], bool(0.01 < left["value"] < 0.03)  # noise of 0.03 mm over three samples, and the gap
    ('mm', True)
    """
    return _in_units(model, find_left(model))


def _in_units(model: Model, sizes: dict[str, float]) -> dict[str, dict[str, Any]]:
    """Sizes of channels [SI] in the units in which they are measured."""
    sensors = SENSORS[model.residuals.runs[0].bench]
    declared = sensors.traces | sensors.means
    return {
        sensor: {"value": size / unit_of(declared[sensor].unit).si("1"), "unit": declared[sensor].unit}
        for sensor, size in sizes.items()
    }


def format_sizes(sizes: dict[str, dict[str, Any]], digits: int = 2) -> str:
    """Sizes of channels as `--tolerance` takes them, each unit once, with the largest size of it.

    >>> format_sizes({"pressure_a": {"value": 2.04, "unit": "kPa"}, "pressure_b": {"value": 1.0, "unit": "kPa"}})
    '2 kPa'
    """
    largest: dict[str, float] = {}
    for size in sizes.values():
        largest[size["unit"]] = max(size["value"], largest.get(size["unit"], 0.0))
    return ", ".join(f"{float(f'{value:.{digits}g}'):g} {unit}" for unit, value in largest.items())
