"""The electro-pneumatic valve.

In the order in which air flows: supply, solenoid, chamber, piston, groove; actuator (all of them together), measures
(of a stroke), bench (the valve alone on its test bench); effects and the terms they add to.
"""
