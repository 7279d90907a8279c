"""The design of what to measure.

In the order in which they build on one another: experiments, isolability, expected_information, forecasts (of each
explanation), outcomes (what each would mean), deciding_trace (beside means alone), next_test.
"""
