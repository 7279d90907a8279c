"""The decision: what is said of the best explanation, by runs that it was not fitted to.

In the order in which they build on one another: operating_points, held_out, verdict, consistency.
"""
