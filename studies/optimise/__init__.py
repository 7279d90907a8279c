"""Command angles that give most torque, least specific air, or the best of both.

In the order in which they build on one another: landscape (what the engine does with other commands, at one speed),
search (the optima and the Pareto front on it), table (all of it over speed, as an archive), summary
(table and JSON), optimisation (the result), figures.
"""
