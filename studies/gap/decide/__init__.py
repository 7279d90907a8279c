"""The decision: what is said of the best explanation, by runs that it was not fitted to.

In the order in which they build on one another: operating_points, windows (means of residuals), left (by channel),
held_out, consistency, odd_files (one that is explained worse), inclusion (of each effect), reliability (of a
statement), facts (that a verdict rests on), verdict, standard_errors (of what is named).
"""
