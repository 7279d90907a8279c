"""What people run: the command line, sweeps, figures.

In the order in which they build on one another. What studies share: execution (in processes), calls (arguments, and
the text of a call), default_grids, operating_conditions, march_status, output (files, and what is there already),
lineage (of machine files), tables, progress, result_kinds, archive_result and grid_result, drawing (of figures). What
is run: valve_run, valve_map, engine_run, engine_ensemble; soft_landing, timing, limit, assessment, optimise, sweep;
discharge, identify and paper. Measured data: measured, measured_check, estimation, gap (the missing effect). What is
there: archives. The installation: doctor. The command line: console, options, commands, cli.
"""
