"""The electro-pneumatic valve.

In the order in which air flows: supply, line, solenoid, solenoid_flow, chamber, piston, groove, ports; ledger (layout
of the states, and sums of the control air), actuator (all of them together), edges (of a command while it is marched),
motion, exergy (of the control air), measures (of a stroke), bench (the valve alone on its test bench), stepping (that
bench in steps), warnings (of a run of it); rig (that moves the piston of a cylinder); effects and the terms they add
to.
"""
