"""Every effect of the library, anew: each function takes a rig and parameters, and gives the rig with the effect.

Names and parameters are those of a machine file, SI, angles in rad; `EFFECTS` lists them.
"""

from typing import NamedTuple

from . import terms
from .engine import Engine
from .sensors import Sensors

CHOKES_AT = 0.528
"""Pressure ratio at which Eq. 8 chokes, as the critical ratio counts it."""
MIN_RAMP = 1e-6
"""[s]"""


class Rig(NamedTuple):
    """What is tested; on the valve's bench nothing but the valve of the engine."""

    engine: Engine = Engine()
    sensors: Sensors = Sensors()

    def valve(self, **values):
        """This with other values of the valve."""
        return self.of_engine(valve=self.engine.valve._replace(**values))

    def of_engine(self, **values):
        """This with other values of the engine."""
        return self._replace(engine=self.engine._replace(**values))

    def reading(self, **values):
        """This with other errors of the sensors."""
        return self._replace(sensors=self.sensors._replace(**values))

    def term(self, term):
        """This with an optional term more."""
        return self.valve(terms=(*self.engine.valve.terms, term))

    def rubbing(self, rub):
        """This with a dry friction more."""
        return self.valve(rubbing=(*self.engine.valve.rubbing, rub))


def later(rig, a, b):
    """Solenoids that follow later, though not before the command."""
    valve = rig.engine.valve
    return rig.valve(delay_a=max(valve.delay_a + a, -valve.dead_time), delay_b=max(valve.delay_b + b, -valve.dead_time))


def slow_ramp(rig, time):
    valve = rig.engine.valve
    release = valve.release_ramp_time
    return rig.valve(
        ramp_time=max(valve.ramp_time + time, MIN_RAMP),
        release_ramp_time=release if release is None else max(release + time, MIN_RAMP),
    )


def pressure_dependent_delay(rig, slope, reference=0.501325e6):
    time = slope * (rig.engine.valve.supply_pressure - reference)
    return later(rig, time, time)


def intake_flow_force(rig, area):
    ambient = rig.engine.valve.ambient_pressure
    return rig.term(terms.force(lambda now: area * (now.receiver[0] - ambient if now.receiver else 0.0)))


def cylinder_wall_heat(rig, h, wall_temperature=300.0, **correlation):
    return rig.term(terms.wall_heat(rig.engine.bore, h, wall_temperature))


def exhaust_timing(rig, angle):
    opens, closes, flank = rig.engine.exhaust
    return rig.of_engine(exhaust=(opens + angle, closes + angle, flank))


def friction_torque(rig, fmep):
    constant, *others = rig.engine.friction
    return rig.of_engine(friction=(constant + fmep, *others))


def supply_droop(rig, feed_area, volume=0.1e-3):
    return rig.valve(line_volume=volume, line_area=feed_area) if feed_area else rig


def intake_pipe_loss(rig, area, volume=0.1e-3):
    return rig.of_engine(pipe_volume=volume, pipe_area=area) if area else rig


def sensor_gain(rig, **shares):
    return rig.reading(gains=rig.sensors.gains | {k: rig.sensors.gains.get(k, 0.0) + v for k, v in shares.items()})


def sensor_offset(rig, **offsets):
    return rig.reading(
        offsets=rig.sensors.offsets | {k: rig.sensors.offsets.get(k, 0.0) + v for k, v in offsets.items()}
    )


EFFECTS = {
    "solenoid_a_delay": lambda rig, time: later(rig, time, 0.0),
    "solenoid_b_delay": lambda rig, time: later(rig, 0.0, time),
    "release_delay": lambda rig, time: rig.valve(release_delay=rig.engine.valve.release_delay + time),
    "slow_ramp": slow_ramp,
    "pressure_dependent_delay": pressure_dependent_delay,
    "critical_ratio": lambda rig, b: rig.valve(stretch=(1.0 - CHOKES_AT) / (1.0 - b)),
    "discharge_coefficient_slope": lambda rig, fall: rig.valve(fall=fall),
    "supply_droop": supply_droop,
    "vent_back_pressure": lambda rig, pressure: rig.valve(vent_excess=pressure),
    "dead_volume": lambda rig, volume: rig.valve(clearance_volume=rig.engine.valve.clearance_volume + volume),
    "ring_leakage": lambda rig, area: rig.term(terms.ring_leakage(rig.engine.valve, area)),
    "leakage_a": lambda rig, area: rig.term(terms.leakage(rig.engine.valve, area, "a")),
    "leakage_b": lambda rig, area: rig.term(terms.leakage(rig.engine.valve, area, "b")),
    "chamber_wall_heat": lambda rig, h, wall_temperature=293.15: rig.term(
        terms.chamber_heat(rig.engine.valve, h, wall_temperature)
    ),
    "moving_mass_error": lambda rig, share: rig.valve(moving_mass=(1.0 + share) * rig.engine.valve.moving_mass),
    "spring_rate_error": lambda rig, share: rig.valve(spring_rate=(1.0 + share) * rig.engine.valve.spring_rate),
    "coulomb_friction": lambda rig, force, breakaway=0.0: rig.valve(
        dry_friction=force, breakaway=max(force, breakaway)
    ),
    "stribeck_friction": lambda rig, force, speed=0.05: rig.rubbing(terms.stribeck(force, speed)),
    "seal_friction": lambda rig, coefficient: rig.rubbing(
        terms.pressed(coefficient, rig.engine.valve.ambient_pressure)
    ),
    "quadratic_drag": lambda rig, coefficient: rig.term(
        terms.force(lambda now: -coefficient * now.speed * abs(now.speed))
    ),
    "side_force": lambda rig, force: rig.term(terms.force(lambda now: force)),
    "intake_flow_force": intake_flow_force,
    "end_cushion": lambda rig, damping, length=0.5e-3: rig.term(
        terms.cushion(rig.engine.valve.stroke, damping, length)
    ),
    "bounce": lambda rig, restitution: rig.valve(restitution=restitution),
    "groove_area_error": lambda rig, share=0.0, taper=0.0: rig.of_engine(
        groove_area=(1.0 + share) * rig.engine.groove_area, taper=taper
    ),
    "seat_leak": lambda rig, area: rig.of_engine(seat_leak=area),
    "clearance_error": lambda rig, share: rig.of_engine(clearance_error=share),
    "cylinder_wall_heat": cylinder_wall_heat,
    "blow_by": lambda rig, area: rig.term(terms.blow_by(rig.engine.valve, area)),
    "exhaust_timing": exhaust_timing,
    "exhaust_restriction": lambda rig, share: rig.of_engine(exhaust_area=(1.0 - share) * rig.engine.exhaust_area),
    "exhaust_back_pressure": lambda rig, pressure: rig.of_engine(exhaust_excess=pressure),
    "friction_torque": friction_torque,
    "intake_pipe_loss": intake_pipe_loss,
    "lift_sensor_lag": lambda rig, time: rig.reading(lift_lag=time),
    "pressure_sensor_lag": lambda rig, time: rig.reading(pressure_lag=time),
    "sensor_gain": sensor_gain,
    "sensor_offset": sensor_offset,
    "time_zero": lambda rig, time: rig.reading(time_zero=rig.sensors.time_zero + time),
    "tdc_error": lambda rig, angle: rig.reading(tdc_error=rig.sensors.tdc_error + angle),
    "speed_ripple": lambda rig, share: rig.reading(speed_ripple=share),
}
