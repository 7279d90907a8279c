"""The missing effect: what lies between a machine and measured data, from the gap to its name.

In the order in which data flow through them: input_checks, search, decide, tables, workflow, design, report.
"""
