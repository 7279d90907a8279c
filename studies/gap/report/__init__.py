"""The report of a verdict, as data, files and a page.

In the order in which they build on one another: effect_rows, comparison, verdict_json, extended_machine, petab_select,
residual_map, html (of template.html).
"""
