"""Pressure that an archive is laid out over: that of the supply, or of the control air."""

from apesim.archive import Archive

PRESSURE_AXES = ("supply_pressure", "control_pressure")
"""Columns of an archive of which one is an axis of its grid."""


def find_pressure_axis(archive: Archive) -> str:
    """Find which of `PRESSURE_AXES` an archive is laid out over: the pressure of the supply, or of the control air."""
    control = archive.variables.get("control_pressure")
    return PRESSURE_AXES[control is not None and control.coordinate]
