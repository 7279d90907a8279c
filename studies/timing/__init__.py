"""Command angles that make the valve really open and close at its targets.

In the order in which they build on one another: open_loop (the delays of the bench), solve (the commands of one
operating point, on the coupled model), table (interpolation in three axes), law (the paper's linear correction for
temperature), grid (all of it over speed, pressure and temperature), header (a table in C, for a controller), export
(CSV, JSON and that header), summary (table and words), figures.
"""

from apesim.studies.timing.solve import Reason, Timing, corrected

__all__ = ["Reason", "Timing", "corrected"]
