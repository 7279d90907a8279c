"""Identification: parameters of a machine from measured data, through the simulator.

The default is bounded least squares from several starts, with the colour of the noise taken off, 95 % intervals by
profile likelihood, and a warning where the data cannot tell parameters apart. The other method is the genetic
algorithm of doi 10.1631/jzus.A0820373, Table 2, which minimises Eq. 11.

The noise of a sensor is an autoregressive process, see `apesim.studies.estimation.noise.process`. Its standard
deviation is the stated one, else from repeats, else from what is left at the optimum; its colour is from repeats, else
from what is left.

The sum of squares bends wherever the simulated contact passes a sample, the more the redder the noise, so that there
are several minima close together: a profile that meets a better point starts the fit again from there.

Runs that are not fitted are judged afterwards, by what is left between them and the model found: one with the role
"gate" refuses the model where that is more than noise and the parameters' uncertainty allow.

In the order in which they build on one another: simulation, free, profile, genetic, fit, shift, gate, figures,
estimate, files.
"""

from apesim.studies.identify.fit import Identified, identify
from apesim.studies.identify.gate import Judgement, judge
from apesim.studies.identify.shift import find_time_shift
from apesim.studies.identify.simulation import Free

__all__ = [
    "Free",
    "Identified",
    "Judgement",
    "find_time_shift",
    "identify",
    "judge",
]
