"""The report of a verdict, as data, files and a page.

In the order in which they build on one another: rounding (of numbers), words (of names), chances (in words);
comparison, engine_curve, curve_notes, calibrated_numbers, effect_rows, likely_cause, run_scatter, discrepancy;
verdict_json, extended_machine, petab_select, residual_map, html (of template.html).
"""
