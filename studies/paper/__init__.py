"""The EPV paper (doi 10.1631/jzus.A0820373), repeated and judged.

In the order in which they build on one another: discharge, the tests of Fig. 3 made by the model; claims, by the part
of the paper that makes them; friction, whether the published friction gives what the text says; subject, whose valve it
is; judgement, all claims; figures; page; repetition, the result of the whole.
"""
