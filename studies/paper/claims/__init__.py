"""Claims of the paper by the part of it that makes them, each judged by the model.

In the order in which they build on one another: claim (what a claim is, and its verdicts); delay, stroke, equations,
design, numerics (the claims on the valve); motion (those on its motion), area (over which areas of the solenoids they
hold); engine (the claims on the valve in the engine).
"""
