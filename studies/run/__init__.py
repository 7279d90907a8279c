"""One operating point, of the valve on its bench or of the engine, and many of them.

In the order in which they build on one another: default_grids, operating_conditions, march_status (how a march ended),
compiling (before the clock starts), engine_run, valve_run, engine_ensemble (many points), doctor (whether all of it
works here).
"""
