"""The electro-pneumatic valve.

In the order in which air flows: supply, line, solenoid, solenoid_flow, chamber, piston, groove, ports; actuator (all of
them together), motion, exergy (of the control air), measures (of a stroke), bench (the valve alone on its test bench);
effects and the terms they add to.
"""
