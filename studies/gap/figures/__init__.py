"""Figures of the missing-effect workflow.

In their order in a report: curve (means over the speed), sizes (the gap of each run), residual_map, overlays (the worst
traces), candidates, latent (what a table says); style (their colours and words), files (all of them).
"""

from apesim.studies.gap.figures.files import draw_gap

__all__ = ["draw_gap"]
