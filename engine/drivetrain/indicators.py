"""Indicators of several cylinders on one shaft in their periodic state: totals, and the valve of each."""

from collections.abc import Sequence
from typing import Any

from apesim.engine.angles import TURN
from apesim.engine.cycle.state import control_ledger, engine_ledger
from apesim.engine.drivetrain.run import draws_from_supply
from apesim.engine.drivetrain.state import (
    FRICTION_WORK,
    MAX_RECEIVER,
    MAX_SPEED,
    MAX_TORQUE,
    MIN_RECEIVER,
    MIN_SPEED,
    MIN_TORQUE,
    own_extremes,
    shaft_extremes,
    shaft_ledger,
)
from apesim.engine.drivetrain.steady import Revolution, gas_work
from apesim.engine.indicators import INDICATORS, exhaust_temperature, indicators, performance, ratio
from apesim.engine.kinematics import swept_volume
from apesim.engine.steady import SteadyRun
from apesim.march.adaptive import LOG_HEAD

VALVE_INDICATORS = (
    *("valve_open_deg", "valve_close_deg", "full_open_deg", "closed_deg", "peak_lift_m"),
    *("opening_seating_speed_m_s", "closing_seating_speed_m_s", "fluctuation", "closing_fluctuation"),
)
"""Indicators of a valve."""
OWN_INDICATORS = (
    *VALVE_INDICATORS,
    *("peak_cylinder_pressure_Pa", "lowest_cylinder_temperature_K"),
    *("indicated_torque_Nm", "engine_air_kg_per_cycle", "control_air_kg_per_cycle"),
)
"""Indicators that are told of each cylinder; angles are its own."""
SHAFT_INDICATORS = {
    "torque_ripple": ("1", "(highest - lowest)/mean torque of the gas in all cylinders"),
    "receiver_dip_Pa": ("Pa", "pressure of the supply less the lowest in the receiver"),
    "lowest_speed_rpm": ("r/min", "lowest speed of the shaft in a revolution"),
    "highest_speed_rpm": ("r/min", "highest speed of the shaft in a revolution"),
}
"""Unit and meaning of what a shaft has beside the indicators of one cylinder."""


def shaft_indicators(
    revolution: Revolution, runs: Sequence[SteadyRun]
) -> tuple[dict[str, Any], list[dict[str, float]]]:
    """Compute the totals of a revolution, `INDICATORS` and `SHAFT_INDICATORS`, and `OWN_INDICATORS` of each cylinder.

    `runs` are those of its cylinders. Work and air are summed, mean effective pressures are over the total
    displacement, the air of two stages is that of the first. Of what valves do, the totals hold that of the first.
    """
    each = [indicators(machine, run) for machine, run in zip(revolution.machines, runs, strict=True)]
    p, end, orbit = revolution.prepared.p, revolution.end, revolution.orbit
    ledgers = [(engine_ledger(run.end), control_ledger(run.end)) for run in runs]

    # Work and air. A cylinder that draws from another one's exhaust takes no air from the supply.
    turns = revolution.speed / TURN
    swept = sum(swept_volume(run.cycle.engine) for run in runs)
    work = sum(engine.work for engine, _ in ledgers)
    fmep = float(end[shaft_ledger(p) + FRICTION_WORK]) / swept
    drawn = sum(engine.groove.mass for (engine, _), draws in zip(ledgers, draws_from_supply(p), strict=True) if draws)
    air = drawn, sum(control.supplied.mass for _, control in ledgers)

    # Extremes stand in the last row of the log, before they begin anew.
    last, extremes, own = revolution.log[-1, LOG_HEAD:], shaft_extremes(p), own_extremes(p, 0)
    low, high = float(last[own + MIN_RECEIVER]), float(last[own + MAX_RECEIVER])
    totals = dict(each[0]) | dict.fromkeys((name for name in INDICATORS if name.startswith("exergy_")), float("nan"))
    totals |= performance(runs[0].cycle, turns, work, fmep, swept, air)
    totals |= {
        "groove_back_flow_kg_per_cycle": sum(engine.groove_back for engine, _ in ledgers),
        "exhaust_back_flow_kg_per_cycle": sum(engine.exhaust_back for engine, _ in ledgers),
        "peak_cylinder_pressure_Pa": max(values["peak_cylinder_pressure_Pa"] for values in each),
        "intake_pressure_fluctuation_Pa": high - low,
        "lowest_cylinder_temperature_K": min(values["lowest_cylinder_temperature_K"] for values in each),
        "exhaust_temperature_K": exhaust_temperature(*(run for i, run in enumerate(runs) if p.sinks[i] < 0)),
        "converged": int(orbit.converged),
        "mass_closure": float(revolution.closure.mass),
        "energy_closure": float(revolution.closure.energy),
        "work_by_quadrature_change": abs(revolution.work_by_quadrature / gas_work(p, end) - 1.0),
        "work_tolerance_change": revolution.work_change,
        "air_tolerance_change": revolution.air_change,
    }
    mean = gas_work(p, end) / TURN
    totals |= {
        "torque_ripple": ratio(float(last[extremes + MAX_TORQUE] - last[extremes + MIN_TORQUE]), mean),
        "receiver_dip_Pa": runs[0].cycle.supply.pressure - low,
        "lowest_speed_rpm": float(last[extremes + MIN_SPEED]) * 60.0 / TURN,
        "highest_speed_rpm": float(last[extremes + MAX_SPEED]) * 60.0 / TURN,
    }
    told = [{name: values[name] for name in OWN_INDICATORS} for values in each]
    return {name: totals[name] for name in (*INDICATORS, *SHAFT_INDICATORS)}, told
