"""Sweeps of operating points: speeds, intakes and any keys of a machine, into one archive.

In the order in which they build on one another: variation (machines that differ in some keys), plan (the operating
points), compute (run them), results (as an archive), completion (until none is missing), run (all of it, safe against
being killed), study (the function for Python, its arguments and its result), table (on the console), figures.
"""

from apesim.studies.sweep.plan import CORRECTED, FIXED, TIMINGS
from apesim.studies.sweep.run import SweepResult, find_finished, run_sweep
from apesim.studies.sweep.variation import vary

__all__ = ["CORRECTED", "FIXED", "TIMINGS", "SweepResult", "find_finished", "run_sweep", "vary"]
