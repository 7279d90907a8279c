"""The engine that breathes through the valve.

In the order in which air flows: breathing (receiver, intake cam, exhaust valve), cylinder, kinematics, friction;
machine (all that a machine file can say), cycle (the coupled march), steady (periodic state), indicators; effects.
"""
