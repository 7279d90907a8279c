"""Limits of the valve and of the engine that it feeds.

valve_map (delay and stroke time over pressure), points (of a map of limits), design_rule (what the limits have in
common), valve_limit (highest rate with complete strokes), engine_limit (highest speed at which the intended timing is
met), summary (for console and JSON), engine_limit_map (the result); figures: lines (what both have in common),
valve_figures (the map of the valve, too), engine_figures.
"""
