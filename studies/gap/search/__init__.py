"""The search for what is missing: from the library over the score of each effect to the models that explain the gap.

In the order in which data flow through them: library, candidates, score_test, phases, gap_test, localisation, refit,
model_selection, intervals, detection_limits.
"""
