"""The EPV paper (doi 10.1631/jzus.A0820373), repeated and judged.

Claims by the part of the paper that makes them: delay, stroke, equations, design, numerics, engine, of which claim says
what they are and claims lists them all; motion, those on the valve's motion, and area, over which solenoid areas they
hold; statements, what the text says of Figs. 9 to 11, and friction, whether the friction gives it; discharge, the tests
of Fig. 3 made by the model; subject, whose valve it is; page, with figures.
"""
