"""What people run: the command line, sweeps, figures.

In the order in which they build on one another. What studies share: execution (in processes), archives (of results),
terminal, drawing (of figures). What is run: run (an operating point), transient (over time), stepping (step by step);
soft_landing, timing, limit (and the map of the valve), assessment, optimise, sweep; discharge, design (of a machine),
identify and paper. For other programs: fmu. Measured data: measured, estimation, gap (the missing effect). Pages:
report (of archives), explore (live). The command line: commands.
"""
