"""Whether the published friction gives what the text says of Figs. 9 to 11.

In the order in which they build on one another: statements (what the text says), friction_map (where that holds).
"""
