"""How large each effect may be where a case hides it, and in which units its size is told."""

from math import radians
from typing import NamedTuple

VALVE, ENGINE = "valve", "engine"


class Hidden(NamedTuple):
    """One parameter of an effect that a case can hide."""

    name: str
    parameter: str
    unit: str
    scale: float
    """SI over that unit."""
    off: float
    """At which it does nothing, or least [unit]."""
    ends: tuple
    """The ends of its range that are not `off` [unit]."""
    benches: tuple = (VALVE, ENGINE)
    needs: tuple = ()
    """Channels without which nothing is seen of it; any of them will do."""
    besides: dict = {}  # noqa: RUF012 - never changed
    """Other parameters: the ends between which they are drawn, SI."""

    def size(self, share, end):
        """The parameter [unit] at a share of the way from off to an end; an area that feeds goes down by ratios."""
        if self.off > 0.0 and self.unit == "mm^2":
            return self.off * (end / self.off) ** share
        return self.off + share * (end - self.off)


ON_PRESSURES = ("pressure_a", "pressure_b", "cylinder_pressure")
OF_ENGINE = ("cylinder_pressure", "torque", "air_flow")
DEGREE, MM2, MS = radians(1.0), 1e-6, 1e-3
OTHER = (ENGINE,)
LIBRARY = {
    entry.name: entry
    for entry in (
        Hidden("solenoid_a_delay", "time", "ms", MS, 0.0, (-1.0, 1.0)),
        Hidden("solenoid_b_delay", "time", "ms", MS, 0.0, (-1.0, 1.0)),
        Hidden("release_delay", "time", "ms", MS, 0.0, (-1.0, 2.0)),
        Hidden("slow_ramp", "time", "ms", MS, 0.0, (-1.4, 1.5)),
        Hidden("pressure_dependent_delay", "slope", "ms/MPa", 1e-9, 0.0, (-2.5, 2.5)),
        Hidden("critical_ratio", "b", "", 1.0, 0.528, (0.2,)),
        Hidden("discharge_coefficient_slope", "fall", "", 1.0, 0.0, (-0.3, 0.3)),
        Hidden("supply_droop", "feed_area", "mm^2", MM2, 50.0, (2.0,), besides={"volume": (0.02e-3, 0.2e-3)}),
        Hidden("vent_back_pressure", "pressure", "kPa", 1e3, 0.0, (30.0,)),
        Hidden("dead_volume", "volume", "mm^3", 1e-9, 0.0, (5000.0,)),
        Hidden("ring_leakage", "area", "mm^2", MM2, 0.0, (0.3,)),
        Hidden("leakage_a", "area", "mm^2", MM2, 0.0, (0.3,)),
        Hidden("leakage_b", "area", "mm^2", MM2, 0.0, (0.3,)),
        Hidden("chamber_wall_heat", "h", "W/(m^2 K)", 1.0, 0.0, (400.0,)),
        Hidden("moving_mass_error", "share", "", 1.0, 0.0, (-0.15, 0.15)),
        Hidden("spring_rate_error", "share", "", 1.0, 0.0, (-0.3, 0.3)),
        Hidden("coulomb_friction", "force", "N", 1.0, 0.0, (12.0,)),
        Hidden("stribeck_friction", "force", "N", 1.0, 0.0, (6.0,), besides={"speed": (0.03, 0.15)}),
        Hidden("seal_friction", "coefficient", "N/Pa", 1.0, 0.0, (1e-4,)),
        Hidden("quadratic_drag", "coefficient", "N s^2/m^2", 1.0, 0.0, (40.0,)),
        Hidden("side_force", "force", "N", 1.0, 0.0, (-12.0, 12.0)),
        Hidden("intake_flow_force", "area", "mm^2", MM2, 0.0, (150.0,), OTHER),
        Hidden("end_cushion", "damping", "N s/m", 1.0, 0.0, (200.0,), besides={"length": (0.3e-3, 1.5e-3)}),
        Hidden("bounce", "restitution", "", 1.0, 0.0, (0.6,)),
        Hidden("groove_area_error", "share", "", 1.0, 0.0, (-0.4, 0.4), OTHER, OF_ENGINE),
        Hidden("seat_leak", "area", "mm^2", MM2, 0.0, (1.0,), OTHER, OF_ENGINE),
        Hidden("clearance_error", "share", "", 1.0, 0.0, (-0.08, 0.08), OTHER, OF_ENGINE),
        Hidden("cylinder_wall_heat", "h", "W/(m^2 K)", 1.0, 0.0, (500.0,), OTHER, OF_ENGINE),
        Hidden("blow_by", "area", "mm^2", MM2, 0.0, (1.0,), OTHER, OF_ENGINE),
        Hidden("exhaust_timing", "angle", "deg", DEGREE, 0.0, (-8.0, 8.0), OTHER, OF_ENGINE),
        Hidden("exhaust_restriction", "share", "", 1.0, 0.0, (0.4,), OTHER, OF_ENGINE),
        Hidden("exhaust_back_pressure", "pressure", "kPa", 1e3, 0.0, (50.0,), OTHER, OF_ENGINE),
        Hidden("friction_torque", "fmep", "kPa", 1e3, 0.0, (-50.0, 50.0), OTHER, ("torque",)),
        Hidden("intake_pipe_loss", "area", "mm^2", MM2, 500.0, (30.0,), OTHER, OF_ENGINE),
        Hidden("lift_sensor_lag", "time", "ms", MS, 0.0, (0.5,)),
        Hidden("pressure_sensor_lag", "time", "ms", MS, 0.0, (0.5,), needs=ON_PRESSURES),
        Hidden("sensor_gain", "lift", "", 1.0, 0.0, (-0.1, 0.1)),
        Hidden("sensor_offset", "lift", "mm", 1e-3, 0.0, (-0.5, 0.5)),
        Hidden("time_zero", "time", "ms", MS, 0.0, (-1.0, 1.0), (VALVE,)),
        Hidden("tdc_error", "angle", "deg", DEGREE, 0.0, (-2.0, 2.0), OTHER, OF_ENGINE),
        Hidden("speed_ripple", "share", "", 1.0, 0.0, (0.04,), OTHER, OF_ENGINE),
    )
}
LATER = "release_delay", "exhaust_back_pressure"
"""Effects that came into the library later: cases of seeds below `FIRST_WITH_ALL` neither hide nor try them."""
FIRST_WITH_ALL = 70000
"""First seed whose case may hide any effect; what a smaller seed makes has been published, and stays as it is."""


def library_at(seed):
    """The effects that the case of a seed can hide."""
    return {name: entry for name, entry in LIBRARY.items() if seed >= FIRST_WITH_ALL or name not in LATER}


CALIBRATED = {
    "groove_area_error": ("groove.effective_area",),
    "exhaust_restriction": ("exhaust.effective_area",),
    "friction_torque": ("friction.constant",),
    "sensor_gain": ("sensor_gain",),
    "sensor_offset": ("sensor_offset",),
    "time_zero": ("time_zero", "dead_time"),
    "tdc_error": ("tdc_error",),
}
"""Effects that are a nuisance, larger than its prior, and that under these keys: that verdict is right, too."""
