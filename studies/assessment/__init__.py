"""What the valve's lateness, finite speed, fluctuation and control air cost.

Between the ideal valve at its intended angles and the real one stand two that have one fault each: late and at once, on
time and slow. What a fault costs depends on whether the other is there already, so both orders are given, and their
Shapley mean. In the order in which they build on one another: causes (what is compared, and what it costs), lift
(lifts that stand for the real one), valves (one operating point), grid (over speed, as an archive), summary
(tables and JSON), comparison (the result), figures.
"""
