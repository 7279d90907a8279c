"""The paper, doi 10.1631/jzus.A0820373, repeated and judged.

Claims by the part of the paper that makes them: delay, stroke, equations, design, of which claim says what they are and
claims lists them all; page, with its figures.
"""
