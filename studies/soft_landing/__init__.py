"""Soft landing by braking re-switches.

In the order in which they build on one another: landing (a stroke with a brake, and how it ends), braking (all brakes
of a grid, and the best of them), strokes (the study over pressures and strokes, and how it holds under other
conditions), results (its archive), summary (tables and JSON), figures.
"""
