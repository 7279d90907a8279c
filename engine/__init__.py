"""The engine that breathes through the valve.

In the order in which air flows: breathing (receiver, intake cam, exhaust valve), gas_exchange, cylinder, kinematics,
friction; machine (all that a machine file can say), cycle_state, cycle (the coupled march), operating_point, steady
(periodic state), exergy (its ledger), ideal_work, indicators; effects.
"""
