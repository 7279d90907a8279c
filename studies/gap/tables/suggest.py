"""What a table looks like: a form in physical variables, by sequentially pruned least squares.

Brunton, Proctor and Kutz 2016, doi 10.1073/pnas.1517384113, here of a smooth latent quantity in place of
derivatives of noise. It suggests, and names nothing.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from apesim.air import GasState
from apesim.effect import law
from apesim.engine.angles import DEGREE
from apesim.engine.machine import Machine
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.parameters import put
from apesim.studies.gap.tables.latent import PERIODIC, find_branches
from apesim.studies.measured import CYLINDER, MeasuredRun
from apesim.studies.measured.prediction import run_of
from apesim.valve.actuator import actuator_of
from apesim.valve.bench import run_bench
from apesim.valve.effects import tabulated_heat
from apesim.valve.piston import volume_a, volume_b
from apesim.valve.rig import drive_force
from apesim.valve.supply import ValveSupply
from apesim.valve.terms import DRY, ENERGY_A, ENERGY_B, FORCE, TERMS, ValveState

MAX_LOST = 0.05
"""Share of the quantity's energy that fewer terms may lose: a term that explains less is not worth reading."""
MIN_EXPLAINED = 0.5
"""Share of its energy from which a form is reported: a form that explains less than half misleads."""
RUN_POINTS = 200
"""Number of points of each run."""
MIN_SPEED = 0.02
"""Speed from which the valve's piston counts as moving [m/s]; a cylinder is looked at in motion alone."""
ALONG_RUNS = "tabulated_force", "tabulated_damping", "tabulated_heat"
"""Tables whose form is looked for along the runs of a valve's bench; of the others over their own places."""
AXES = {
    "tabulated_leak": ("(lift/stroke)", 100.0),
    "tabulated_area": ("r", 100.0),
    "tabulated_delay": ("x", 100.0),
    "tabulated_delay.pressure": ("(p_c/MPa)", 1000.0),
    "tabulated_groove": ("s", 100.0),
}
"""Symbol of the quantity over which a table stands, and the value that is 1 of it."""

Form = tuple[str, np.ndarray, dict[str, tuple[str, np.ndarray]]]
"""A quantity: its unit, its values, and the terms that may explain it, each with its unit and its values."""


def fit_sparse(target: np.ndarray, terms: Mapping[str, np.ndarray]) -> tuple[dict[str, float], float]:
    """Fit few terms to a quantity by least squares: the term that is missed least is dropped, again and again.

    It ends before the share `MAX_LOST` of the energy of `target` (n,) would be lost against the fit of all terms.
    Returned are the weights of the terms that stay, by name, and the share of the energy that they explain. It is
    sparse identification (Brunton, Proctor and Kutz 2016, doi 10.1073/pnas.1517384113) by elimination of terms, in
    place of a threshold.
    """

    def fit(names: list[str]) -> tuple[float, dict[str, float]]:
        columns = np.column_stack([terms[name] for name in names])
        weights = np.linalg.lstsq(columns, target, rcond=None)[0]
        return float(np.sum((target - columns @ weights) ** 2)), dict(zip(names, weights, strict=True))

    energy, names = float(target @ target), list(terms)
    missed, weights = fit(names)
    max_missed = missed + MAX_LOST * energy
    while len(names) > 1:
        missed_without, dispensable = min((fit([n for n in names if n != name])[0], name) for name in names)
        if missed_without > max_missed:
            break
        names.remove(dispensable)
        missed, weights = fit(names)
    return weights, 1.0 - missed / energy if energy else 0.0


def suggest_form(model: Model) -> str:
    """Suggest the form of a law that a fitted table looks like; the table is the last candidate of `model`.

    There is one form for each quantity that the table changes; "" where there is none.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> from apesim.studies.gap.tables.balance import fit_table
    >>> table = next(each for each in explain_example().balances if each.name == "tabulated_force")
    >>> form = suggest_form(fit_table(explain_example().calibrated, table).model)
    >>> form.partition(" ~ ")[0]
    'force to closed, x the lift from mid stroke'
    """
    name = model.candidates[-1].name
    if name in ALONG_RUNS:
        forms = _list_terms_along_runs(model, name)
    else:
        forms = _list_terms_over_nodes(model, name)
    texts = []
    for what, (unit, target, terms) in forms.items():
        weights, explained = fit_sparse(target, {term: values for term, (_, values) in terms.items()})
        parts = [f"{value:.3g}{_write_unit(unit, terms[term][0])} {term}".strip() for term, value in weights.items()]
        if explained > MIN_EXPLAINED:
            texts.append(f"{what} ~ {' + '.join(parts)} ({100.0 * explained:.0f} % of it)".replace("+ -", "- "))
    return "; ".join(texts)


def _write_unit(unit: str, other: str) -> str:
    """Unit of a coefficient."""
    if unit and other:
        return f" {unit}/({other})"
    return f" {unit}" if unit else f" 1/({other})" if other else ""


def _list_terms_over_nodes(model: Model, name: str) -> dict[str, Form]:
    """Each branch of a table that moved, over its nodes."""
    forms: dict[str, Form] = {}
    for branch in find_branches(model):
        positions = branch.positions
        if name in PERIODIC:
            terms = {
                "": np.ones_like(positions),
                "cos(angle)": np.cos(positions * DEGREE),
                "sin(angle)": np.sin(positions * DEGREE),
            }
        else:
            axis, whole = AXES[key] if (key := f"{name}.{branch.name}") in AXES else AXES[name]
            terms = {"": np.ones_like(positions), axis: positions / whole, f"{axis}^2": (positions / whole) ** 2}
        without_units = {term: ("", values) for term, values in terms.items()}
        forms[branch.name.replace("_", " ")] = branch.unit, branch.values, without_units
    return forms


def _list_terms_along_runs(model: Model, name: str) -> dict[str, Form]:
    """The force on the piston, or the heat into the chambers, against what the fitted runs go through."""
    rows: list[tuple[float, ...]] = []

    # The states of all fitted runs together: one form has to hold for them all.
    for run in model.residuals.runs:
        machine = put(run_of(model.residuals.machine, run), model.residuals.parameters, model.fitted.x)
        rows += _simulate_states(machine, run, name)
    speed, middle, p_a, p_b, t_a, t_b, force, heat_a, heat_b = np.array(rows).T
    sign = np.sign(speed)

    # Heat is explained in each chamber by its own air, and by the speed.
    if name == tabulated_heat.EFFECT.name:
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

    # A force is explained by the motion, the place and the pressures; friction changes its sign with the motion.
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

    # At rest the motion has no sign, and friction is whatever holds the piston: those samples are left out.
    moving = abs(speed) > (0.0 if model.residuals.runs[0].bench == CYLINDER else MIN_SPEED)
    return {
        "force to closed, x the lift from mid stroke": (
            "N",
            force[moving],
            {term: (unit, v[moving]) for term, (unit, v) in terms.items()},
        )
    }


def _simulate_states(machine: Machine, run: MeasuredRun, name: str) -> Iterator[tuple[float, ...]]:
    """Speed to closed, lift from mid stroke [mm], pressures [MPa] and temperatures above ambient, force and heats."""
    if run.bench == CYLINDER:
        yield from _simulate_rig_states(machine, run, name)
        return

    # The motion with the table in the machine; a state of it for each point in time.
    bench = run_bench(machine, run.pulse, float(run.times[-1]), sample=np.linspace(0.0, run.times[-1], RUN_POINTS))
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

        # The law of the table alone, at that state: what the rest of the machine does is in the motion already.
        balance = np.zeros(TERMS)
        law(effect, state, balance)

        # States above ambient. Dry friction has no sign in a balance, and acts against the motion.
        above = (p_a - ambient.pressure) / 1e6, (p_b - ambient.pressure) / 1e6
        warmer = t_a - ambient.temperature, t_b - ambient.temperature
        force = balance[FORCE] - np.sign(speed) * balance[DRY]
        middle = 1e3 * lift - 0.5e3 * machine.valve.stroke
        yield speed, middle, *above, *warmer, force, balance[ENERGY_A], balance[ENERGY_B]


def _simulate_rig_states(machine: Machine, run: MeasuredRun, name: str) -> Iterator[tuple[float, ...]]:
    """What `_simulate_states` gives, of a cylinder that a drive moves: its stroke is the lift."""
    stroke, pressure, velocity = (run.given[each] for each in ("stroke", "pressure", "velocity"))
    off = machine._replace(effects=machine.effects._replace(**{name: type(getattr(machine.effects, name))()}))
    forces = drive_force(machine, stroke, pressure, velocity) - drive_force(off, stroke, pressure, velocity)
    middles = 1e3 * (stroke - 0.5 * (stroke.min() + stroke.max()))
    gauge = (pressure - machine.ambient.pressure) / 1e6
    for speed, middle, above, force in np.column_stack([-velocity, middles, gauge, forces]).tolist():
        yield speed, middle, above, 0.0, 0.0, 0.0, force, 0.0, 0.0
