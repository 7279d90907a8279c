"""The engine that breathes through the valve.

In the order in which air flows: receiver, cam (of the intake), exhaust, cylinder, kinematics, friction, second_stage
(with its inter-receiver), command, shaft (with its load); stated_uncertainties (how far numbers are known), proportions
(numbers that belong together), first_keys (of a short file), machine (all that a machine file can say), cycle (what is
marched), drivetrain (cylinders on one shaft, over time), steady (periodic state), exergy (its ledger), ideal_work,
indicators, warnings; angles (units of crank angles); effects, outside_machine (with effects from files of a user) and
effect_trial (of each of those).
"""
