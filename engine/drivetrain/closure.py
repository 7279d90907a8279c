"""Closure of a run of a drivetrain: mass and energy of the air, and energy of the shaft, that are not accounted for."""

from math import nan
from typing import NamedTuple

import numpy as np

from apesim.engine.cycle.state import control_ledger, effects_ledger, engine_ledger, gas_held, has_pipe
from apesim.engine.drivetrain.preparing import Prepared
from apesim.engine.drivetrain.state import (
    EXCHANGED_HEAT,
    FRICTION_WORK,
    GAS_WORK,
    LOAD_WORK,
    SPEED,
    WALL_HEAT,
    block_of,
    cylinder_of,
    ledger_at,
    ledger_place,
    shaft_extremes,
    shaft_ledger,
    shaft_states,
)
from apesim.march.error_bounds import closure_of


class Closure(NamedTuple):
    """What a run does not account for, over what is turned over."""

    mass: float
    """Mass of the air."""
    energy: float
    """Energy of the air."""
    shaft: float
    """Energy of the shaft; NaN where its speed is imposed."""


def closure_of_run(prepared: Prepared, end: np.ndarray) -> Closure:
    """Find the mass and energy of all air, and the energy of the shaft, that a run from its start leaves open.

    ``dU = H_in - H_out + Q - sum(int p dV)`` and ``J d(omega^2)/2 = W_gas - W_friction - W_load``: the balances of all
    gas volumes together, and of the shaft. How small sums are treated, see `apesim.march.error_bounds.closure_of`.

    The measure is defined here: what is open, over what flows and works.

    Parameters
    ----------
    prepared : apesim.engine.drivetrain.preparing.Prepared
        Drivetrain with its state at the start.
    end : (n,) float array
        State vector at the end of the march from there.

    Returns
    -------
    Closure
        Relative mass and energies that are not accounted for.

    Examples
    --------
    >>> from apesim.engine.drivetrain.preparing import prepare
    >>> from apesim.engine.drivetrain.run import run_drivetrain
    >>> from apesim.engine.machine import Machine
    >>> start = prepare(Machine(), 0.5)
    >>> all(float(part) < 1e-9 for part in closure_of_run(start, run_drivetrain(start, 1e-4).y))
    True
    """
    p = prepared.p
    counted = shaft_extremes(p)
    change = end[:counted] - prepared.y[:counted]
    shaft = change[shaft_ledger(p) :]
    mass = energy = mass_through = energy_through = 0.0
    energy -= float(shaft[EXCHANGED_HEAT] + shaft[WALL_HEAT])

    # What each cylinder takes from outside and gives there; what passes between the volumes is within.
    for i in range(len(p.numbers)):
        c = cylinder_of(p, prepared.y, prepared.mode, i)
        own = ledger_at(change, ledger_place(p, i))
        engine, control, let_in = engine_ledger(own), control_ledger(own), effects_ledger(own)
        holder = cylinder_of(p, prepared.y, prepared.mode, int(p.sources[i]))
        flows = [engine.feed] if i == 0 and c.receiver_volume > 0.0 else []
        if holder.receiver_volume == 0.0:
            flows.append(engine.pipe if has_pipe(c) else engine.groove)
        if not (c.control_from_receiver and holder.receiver_volume > 0.0):
            flows.append(control.line_fed)
        outward = [control.vented, engine.exhaust] if p.sinks[i] < 0 else [control.vented]
        stored = gas_held(block_of(change, i))
        mass += stored[0] - sum(flow.mass for flow in (*flows, let_in)) + sum(flow.mass for flow in outward)
        energy += stored[1] - sum(flow.enthalpy for flow in (*flows, let_in))
        energy += sum(flow.enthalpy for flow in outward) + engine.work + control.valve_work
        mass_through += abs(engine.groove.mass) + abs(control.supplied.mass) + engine.groove_back + engine.exhaust_back
        energy_through += abs(engine.groove.enthalpy) + abs(control.supplied.enthalpy) + abs(engine.exhaust.enthalpy)
    held = np.sum([gas_held(block_of(prepared.y, i)) for i in range(len(p.numbers))], axis=0)

    if p.is_imposed:
        unbalanced = nan
    else:
        speed, speed_end = (state[shaft_states(p) + SPEED] for state in (prepared.y, end))
        kinetic = 0.5 * p.shaft.inertia * (speed_end**2 - speed**2)
        works = shaft[GAS_WORK], shaft[FRICTION_WORK], shaft[LOAD_WORK]
        turned_over = float(np.abs([kinetic, *works]).max())
        open_work = kinetic - works[0] + works[1] + works[2]
        unbalanced = float(abs(open_work) / turned_over) if turned_over else 0.0
    return Closure(
        closure_of(mass, mass_through, float(held[0])), closure_of(energy, energy_through, float(held[1])), unbalanced
    )
