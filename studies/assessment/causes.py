"""What is compared between the ideal and the real valve, and what each cause of a difference costs."""

import numpy as np

VALVES = {
    "ideal": "on time, at once: full groove area from one intended angle to the other",
    "on_time_constant_speed": "crosses the lap at the intended angles, at the constant speeds of the real lift",
    "on_time_real_lift": "crosses the lap at the intended angles, with the flanks of the real lift",
    "late_at_once": "full groove area at once, while the real lift is above the lap",
    "late_constant_speed": "crosses the lap, reaches and leaves its peak where the real lift does, at constant speeds",
    "late_real_lift": "the real lift, its control air not counted",
    "real": "the real lift with its control air",
}
"""Each valve that is compared, and what it does."""
CAUSES = {
    "lateness": "the lift crosses the lap later than intended, at both ends",
    "finite_speed": "the real lift takes its time and may not be full, fluctuation included",
    "fluctuation": "part of finite_speed: the real lift against one at constant speeds",
    "control_air": "the valve has to be driven: from late_real_lift to real",
}
"""What makes a real valve worse than an ideal one. All but fluctuation sum up to the whole, in any order."""
ORDERS = {
    "lateness_first": "from ideal to late_at_once, then to late_real_lift",
    "finite_speed_first": "from ideal to on_time_real_lift, then to late_real_lift",
    "mean": "Shapley mean of the two orders",
}
"""Ways from the ideal to the real valve: what a cause costs depends on whether the other is there already."""
STEPS = {
    "lateness": (("ideal", "late_at_once"), ("on_time_real_lift", "late_real_lift")),
    "finite_speed": (("late_at_once", "late_real_lift"), ("ideal", "on_time_real_lift")),
    "fluctuation": (("late_constant_speed", "late_real_lift"), ("on_time_constant_speed", "on_time_real_lift")),
    "control_air": 2 * (("late_real_lift", "real"),),
}
"""Between which valves each cause stands: lateness first, and finite speed first."""
MEASURES = {
    "indicated_torque_Nm": ("N m", "indicated torque"),
    "brake_torque_Nm": ("N m", "brake torque"),
    "air_kg_per_cycle": ("kg", "all air in a cycle"),
    "specific_air_kg_per_kWh": ("kg/kWh", "all air over brake work"),
    "indicated_specific_air_kg_per_kWh": ("kg/kWh", "all air over indicated work"),
}
"""Name of each measure of a valve: its unit and what it is."""
LOSSES = {
    "indicated_torque_lost_Nm": -1.0,
    "brake_torque_lost_Nm": -1.0,
    "air_added_kg_per_cycle": 1.0,
    "specific_air_added_kg_per_kWh": 1.0,
    "indicated_specific_air_added_kg_per_kWh": 1.0,
}
"""Name of each measure's loss, in the order of `MEASURES`, and its sign: a loss is positive, a gain negative."""
REAL = (
    *("valve_open_deg", "valve_close_deg", "full_open_deg", "closed_deg", "peak_lift_m"),
    *("fluctuation", "closing_fluctuation", "intake_pressure_fluctuation_Pa", "period_cycles", "periodic_change"),
)
"""Indicators of the real valve that stand beside."""
EXERGY = {
    "engine_air": ("exergy that engine air brings", ("engine_air",)),
    "control_air": ("exergy that control air brings", ("control_air",)),
    "indicated_work": ("indicated work", ("indicated_work",)),
    "feed": ("exergy destroyed by throttling in the feed", ("feed",)),
    "groove": ("exergy destroyed by throttling in the groove", ("groove",)),
    "exhaust": ("exergy destroyed in the exhaust valves or carried off through them", ("exhaust_valve", "exhaust_air")),
    "valve_drive": (
        "exergy destroyed or carried off in driving the valve",
        ("solenoids", "chamber_mixing", "vents", "vented_air", "valve_friction", "valve_impacts"),
    ),
    "other": (
        "exergy destroyed by mixing, leaks and heat transfer, less what heat from the walls brings, and stored",
        ("receiver_mixing", "cylinder_mixing", "leaks", "heat_transfer", "wall_heat", "stored"),
    ),
}
"""Sources and sinks of a cycle's exergy: what it is, and its terms of `apesim.engine.exergy`."""
ENTERS = ("engine_air", "control_air")
"""Those of `EXERGY` that come in; they are the sum of the others."""
LATENESS = {
    "lateness_deg": ("deg", "true angle less the intended one"),
    "delay_deg": ("deg", "part of the lateness: delay time t_d, command edge to 1 % of the stroke"),
    "travel_deg": ("deg", "part of the lateness: from 1 % of the stroke to the lap"),
    "advance_deg": ("deg", "intended angle less that of the command: lateness is delay and travel less this"),
    "delay_s": ("s", "delay time t_d, command edge to 1 % of the stroke"),
}
"""What the lateness of an opening or a closing is made of: its unit and what it is."""


def losses(valves: np.ndarray) -> np.ndarray:
    """Find what each of `CAUSES` costs, in each of `ORDERS`: (..., 3, 4, 5), from `MEASURES` of `VALVES`, (..., 7, 5).

    In each order lateness, finite speed and control air sum up to the difference between the first and the last valve;
    the mean of the orders is Shapley's value of two players (Shapley 1953, doi 10.1515/9781400881970-018).

    >>> torque = np.array([40.0, 39.0, 38.0, 35.0, 34.0, 31.0, 31.0])  # of each valve [N m]
    >>> lost = losses(np.repeat(torque[:, np.newaxis], 5, axis=1))
    >>> dict(zip(CAUSES, lost[0, :, 1].tolist()))  # lateness first
    {'lateness': 5.0, 'finite_speed': 4.0, 'fluctuation': 3.0, 'control_air': 0.0}
    >>> dict(zip(CAUSES, lost[2, :, 1].tolist()))  # mean of both orders
    {'lateness': 6.0, 'finite_speed': 3.0, 'fluctuation': 2.0, 'control_air': 0.0}
    """
    number = {name: at for at, name in enumerate(VALVES)}
    orders = [
        [valves[..., number[late], :] - valves[..., number[early], :] for early, late in steps]
        for steps in zip(*STEPS.values(), strict=True)
    ]
    both = np.stack([np.stack(causes, axis=-2) for causes in orders], axis=-3)
    changes = np.concatenate((both, both.mean(axis=-3, keepdims=True)), axis=-3)
    return changes * np.array(list(LOSSES.values())) + 0.0  # no -0.0
