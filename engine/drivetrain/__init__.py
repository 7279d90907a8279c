"""Drivetrain: cylinders on one shaft, whose speed is a state or imposed over time, marched in time.

state (what is integrated, and the numbers of states, ledgers and modes), corners (angles at which something switches,
and the edges of commands), shaft_balance (torques on the shaft, rest and breakaway), rates (the coupled march),
preparing (a machine as the march takes it, at rest), run (marches over time), checkpoint (what a march goes on from),
control (controllers between revolutions), stepping (a march in steps), feedback_timing (a controller of the valves'
timing), closure (what a run leaves open), start (starts from rest), steady (the periodic state), indicators (of all
cylinders), point (an operating point, of one cylinder or of several).
"""
