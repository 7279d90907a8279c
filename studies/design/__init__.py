"""A machine of one's own, from what its builder can answer.

In the order in which they build on one another: conductance (of a solenoid valve, by ISO 6358, as an effective area),
questions (what a builder is asked), estimates (of what valve and engine need), rules (what follows from the answers,
each with its reason), plausibility (what is odd about the machine), machine_design (all of it, as a result), dialogue
(asking on a terminal).
"""
