"""The genetic algorithm of the EPV paper (doi 10.1631/jzus.A0820373), Table 2."""

from typing import Any

import numpy as np

from apesim.quantities import Fault, InputError
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.identify.simulation import find_differences, find_objective

POPULATION, GENERATIONS = 20, 80


def minimise_genetically(residuals: WhitenedResiduals, generations: int = GENERATIONS, seed: int = 0) -> np.ndarray:
    """Minimise [EPV, Eq. 11] by a genetic algorithm of floating-point strings, `POPULATION` in each generation.

    Returns the scaled parameters (p,) of the least value met. Raises InputError where pymoo is not installed.

    Friction of a valve from its lift, in two of the 80 generations:

    >>> from apesim.engine.machine import Machine
    >>> from apesim.studies.gap.example_bench import read_example
    >>> from apesim.studies.identify.free import free_parameters
    >>> from apesim.studies.identify.simulation import free_residuals
    >>> [free] = free_parameters(Machine(), ["valve.viscous_friction=100 N s/m:120 N s/m"])
    >>> [x] = minimise_genetically(free_residuals(Machine(), read_example().of("fit"), [free]), generations=2)
    >>> bool(100.0 <= x * free.scale <= 120.0)
    True
    """
    try:
        from pymoo.algorithms.soo.nonconvex.ga import GA
        from pymoo.core.problem import ElementwiseProblem
        from pymoo.optimize import minimize
    except ImportError:
        right = "pip install 'apesim[ga]', or leave --method out"
        raise InputError([Fault("command line", "--method", "the genetic algorithm needs pymoo", right)]) from None

    class Evaluation(ElementwiseProblem):
        def _evaluate(self, x: np.ndarray, out: dict[str, float], *args: Any, **kwargs: Any) -> None:
            out["F"] = find_objective(residuals, find_differences(residuals, x))

    low, high = residuals.low, residuals.high
    strings = GA(pop_size=POPULATION, eliminate_duplicates=False)
    best = minimize(Evaluation(n_var=len(low), n_obj=1, xl=low, xu=high), strings, ("n_gen", generations), seed=seed)
    return np.atleast_1d(best.X)
