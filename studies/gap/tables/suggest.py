"""What a table looks like: a form in physical variables, by sequentially pruned least squares.

Brunton, Proctor and Kutz 2016, doi 10.1073/pnas.1517384113, here of a smooth latent quantity in place of
derivatives of noise. It suggests, and names nothing.
"""

import numpy as np

from apesim.air import GasState
from apesim.effect import law
from apesim.engine.angles import DEGREE
from apesim.studies.estimation.parameters import put
from apesim.studies.gap.tables.latent import ROUND, branches
from apesim.studies.measured.prediction import run_of
from apesim.valve.actuator import actuator_of
from apesim.valve.bench import run_bench
from apesim.valve.piston import volume_a, volume_b
from apesim.valve.supply import ValveSupply
from apesim.valve.terms import DRY, ENERGY_A, ENERGY_B, FORCE, TERMS, ValveState

LOST = 0.05
"""Share of the latent quantity's energy that fewer terms may lose."""
TOLD = 0.5
"""Share of its energy from which a form is told."""
POINTS = 200
"""Number of points of each run."""
MOVING = 0.02
"""Speed from which the piston counts as moving [m/s]."""
ALONG = "tabulated_force", "tabulated_damping", "tabulated_heat"
"""Tables whose form is looked for along the runs of a valve's bench; of the others over their own places."""
AXES = {
    "tabulated_leak": ("(lift/stroke)", 100.0),
    "tabulated_area": ("r", 100.0),
    "tabulated_delay": ("x", 100.0),
    "tabulated_delay.pressure": ("(p_c/MPa)", 1000.0),
    "tabulated_groove": ("s", 100.0),
}
"""What the places of a table are, and what is 1."""


def sparse(target, terms):
    """Fit few terms to a quantity by least squares: the term that is missed least is dropped, again and again.

    It ends before the share `LOST` of the quantity's energy would be lost against the fit of all terms.

    It is sparse identification [1]_ by elimination of terms, in place of a threshold.

    Parameters
    ----------
    target : (n,) float array
        The quantity.
    terms : dict of (n,) float array
        Values of each term, by name.

    Returns
    -------
    weights : dict
        By name, of the terms that stay.
    explained : float
        Share of the quantity's energy that they explain.

    References
    ----------
    .. [1] S. L. Brunton, J. L. Proctor and J. N. Kutz, "Discovering governing equations from data by sparse
       identification of nonlinear dynamical systems", PNAS 113, 2016, pp. 3932-3937, doi 10.1073/pnas.1517384113.

    Examples
    --------
    >>> x = np.array([-2.0, -1.0, 1.0, 2.0])
    >>> weights, explained = sparse(3.0 * x, {"x": x, "x^2": x**2})
    >>> {name: round(float(weight), 6) for name, weight in weights.items()}, round(explained, 6)
    ({'x': 3.0}, 1.0)
    """

    def fitted(names):
        columns = np.column_stack([terms[name] for name in names])
        weights = np.linalg.lstsq(columns, target, rcond=None)[0]
        return float(np.sum((target - columns @ weights) ** 2)), dict(zip(names, weights, strict=True))

    energy, names = float(target @ target), list(terms)
    left, weights = fitted(names)
    most = left + LOST * energy
    while len(names) > 1:
        lost, least = min((fitted([n for n in names if n != name])[0], name) for name in names)
        if lost > most:
            break
        names.remove(least)
        left, weights = fitted(names)
    return weights, 1.0 - left / energy if energy else 0.0


def suggestion(model):
    """The form that a fitted table suggests.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model
        With the table as its last candidate.

    Returns
    -------
    str
        One form for each quantity that the table changes; "" where there is none.
    """
    name = model.candidates[-1].name
    if name in ALONG:
        forms = _along_the_runs(model, name)
    else:
        forms = _over_the_nodes(model, name)
    texts = []
    for what, (unit, target, terms) in forms.items():
        found, explained = sparse(target, {term: values for term, (_, values) in terms.items()})
        parts = [f"{value:.3g}{_per(unit, terms[term][0])} {term}".strip() for term, value in found.items()]
        if explained > TOLD:
            texts.append(f"{what} ~ {' + '.join(parts)} ({100.0 * explained:.0f} % of it)".replace("+ -", "- "))
    return "; ".join(texts)


def _per(unit, other):
    """Unit of a coefficient."""
    if unit and other:
        return f" {unit}/({other})"
    return f" {unit}" if unit else f" 1/({other})" if other else ""


def _over_the_nodes(model, name):
    """Each branch of a table that moved, over its places."""
    found = {}
    for branch in branches(model):
        places = branch.places
        if name in ROUND:
            terms = {
                "": np.ones_like(places),
                "cos(angle)": np.cos(places * DEGREE),
                "sin(angle)": np.sin(places * DEGREE),
            }
        else:
            axis, whole = AXES.get(f"{name}.{branch.name}", AXES.get(name))
            terms = {"": np.ones_like(places), axis: places / whole, f"{axis}^2": (places / whole) ** 2}
        told = {term: ("", values) for term, values in terms.items()}
        found[branch.name.replace("_", " ")] = branch.unit, branch.values, told
    return found


def _along_the_runs(model, name):
    """The force on the piston, or the heat into the chambers, against what the fitted runs go through."""
    rows = []
    for run in model.residuals.runs:
        machine = put(run_of(model.residuals.machine, run), model.residuals.parameters, model.fitted.x)
        rows += _states(machine, run, name)
    rows = np.array(rows)
    speed, lift, p_a, p_b, t_a, t_b, force, heat_a, heat_b = rows.T
    sign, middle = np.sign(speed), lift - 0.5e3 * model.residuals.machine.valve.stroke
    if name == "tabulated_heat":
        heats = (("A", heat_a, t_a, p_a), ("B", heat_b, t_b, p_b))
        return {
            f"heat into chamber {chamber}": (
                "W",
                heat,
                {
                    "": ("", np.ones_like(heat)),
                    "(T - T_0)": ("K", t),
                    "(p - p_0)": ("MPa", p),
                    "|v|": ("m/s", abs(speed)),
                },
            )
            for chamber, heat, t, p in heats
        }
    terms = {
        "": ("", np.ones_like(sign)),
        "sign(v)": ("", sign),
        "v": ("m/s", speed),
        "v |v|": ("m^2/s^2", speed * abs(speed)),
        "x": ("mm", middle),
        "x^2": ("mm^2", middle**2),
        "x^3": ("mm^3", middle**3),
        "x sign(v)": ("mm", middle * sign),
        "|x| sign(v)": ("mm", abs(middle) * sign),
        "x v": ("mm m/s", middle * speed),
        "(p_A - p_B)": ("MPa", p_a - p_b),
        "(p_A + p_B - 2 p_0) sign(v)": ("MPa", (p_a + p_b) * sign),
    }
    moving = abs(speed) > MOVING
    return {
        "force to closed, x the lift from mid stroke": (
            "N",
            force[moving],
            {term: (unit, v[moving]) for term, (unit, v) in terms.items()},
        )
    }


def _states(machine, run, name):
    """Speed to closed, lift [mm], pressures [MPa] and temperatures above ambient, force and heats of a table."""
    bench = run_bench(machine, run.pulse, float(run.times[-1]), sample=np.linspace(0.0, run.times[-1], POINTS))
    actuator, _ = actuator_of(machine, [0.0, run.pulse], np.inf)
    ambient, effect = actuator.ambient, getattr(machine.effects, name)
    supply = ValveSupply(machine.supply.control(), ambient.pressure)
    for lift, velocity, p_a, p_b, t_a, t_b in bench.trace:
        position, speed = actuator.valve.stroke - lift, -velocity
        state = ValveState(
            actuator.gas,
            ambient,
            actuator.valve,
            position,
            speed,
            GasState(p_a, t_a),
            volume_a(actuator.valve, position),
            GasState(p_b, t_b),
            volume_b(actuator.valve, position),
            supply,
            actuator.vent_pressure,
            actuator.stretch,
        )
        balance = np.zeros(TERMS)
        law(effect, state, balance)
        above = (p_a - ambient.pressure) / 1e6, (p_b - ambient.pressure) / 1e6
        warmer = t_a - ambient.temperature, t_b - ambient.temperature
        force = balance[FORCE] - np.sign(speed) * balance[DRY]
        yield speed, 1e3 * lift, *above, *warmer, force, balance[ENERGY_A], balance[ENERGY_B]
