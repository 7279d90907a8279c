"""The search for what is missing: from the library over the score of each effect to the models that explain the gap.

In the order in which data flow through them: library, candidates, file_numbers (of the machine file), run_faults (of
one file), calibrated_gap, score_test, phases, gap_test, localisation, refit, candidate_fits, scatter_beside (of the
runs, with effects), plausibility (of a fit), linear_sets, model_selection, intervals, detection_limits.
"""
