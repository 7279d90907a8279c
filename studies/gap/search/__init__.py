"""The search for what is missing: from the library over the score of each effect to the models that explain the gap.

In the order in which data flow through them: library, candidates, run_faults (of one file), calibrated_gap, score_test,
phases, gap_test, localisation, refit, candidate_fits, scatter_beside (of the runs, with effects), plausibility (of a
fit), model_selection, intervals, detection_limits.
"""
