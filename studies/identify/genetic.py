"""The genetic algorithm of doi 10.1631/jzus.A0820373, Table 2."""

import numpy as np

from apesim.quantities import Fault, InputError
from apesim.studies.identify.simulation import find_differences, find_objective

POPULATION, GENERATIONS = 20, 80


def genetic(residuals, generations=GENERATIONS, seed=0):
    """Minimise Eq. 11 of the EPV paper (doi 10.1631/jzus.A0820373) by a genetic algorithm of floating-point strings.

    Parameters
    ----------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals
    generations : int
    seed : int

    Returns
    -------
    (p,) float array
        Scaled parameters of the least value met.

    Raises
    ------
    apesim.quantities.InputError
        pymoo is not installed.
    """
    try:
        from pymoo.algorithms.soo.nonconvex.ga import GA
        from pymoo.core.problem import ElementwiseProblem
        from pymoo.optimize import minimize
    except ImportError:
        right = "pip install 'apesim[ga]', or leave --method out"
        raise InputError([Fault("command line", "--method", "the genetic algorithm needs pymoo", right)]) from None

    class Evaluation(ElementwiseProblem):
        def _evaluate(self, x, out, *args, **kwargs):
            out["F"] = find_objective(residuals, find_differences(residuals, x))

    low, high = residuals.low, residuals.high
    strings = GA(pop_size=POPULATION, eliminate_duplicates=False)
    found = minimize(Evaluation(n_var=len(low), n_obj=1, xl=low, xu=high), strings, ("n_gen", generations), seed=seed)
    return np.atleast_1d(found.X)
