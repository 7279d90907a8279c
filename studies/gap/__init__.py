"""The missing effect: what lies between a machine and measured data, from the gap to its name.

In the order in which data flow through them: input_checks, tolerance, stage_work (processes and progress), search,
thresholds and reasons (of a decision), decide, tables, design, report, figures, explanation (the result), workflow;
example_bench (to try it).
"""
