"""What the valve's delay, finite speed, fluctuation and control air cost.

A chain of valves loses one virtue after the other, from the ideal one at its intended angles to the real one with its
control air; each step costs torque and air, and the costs sum up to the whole. In the order in which they build on one
another: lift (lifts that stand for the real one), chain (one operating point), grid (over speed, as an archive).
"""
