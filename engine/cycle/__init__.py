"""The engine's cycle, marched together with its valve.

state (what is integrated), flows (through intake pipe, groove, exhaust and feed), rates (the coupled march),
operating_point (a machine and a speed as the march takes them).
"""
