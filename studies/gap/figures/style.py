"""Colours and words that the figures of the missing-effect workflow share."""

from apesim.studies.drawing.style import BLUE, RED, Look
from apesim.studies.measured import CHECK, FIT, GATE

MEASURED, BEFORE, AFTER = "0.55", RED, BLUE
"""Colours of what was measured, of the calibrated model, and of the model with what was added."""
WORDS = {CHECK: "never used", GATE: "used to judge", FIT: "fitted"}
"""What was done with a run, by its role."""
MARKS = {CHECK: " *", GATE: " †", FIT: ""}
"""Marks behind the name of a run, by its role."""
WIDTH = 7.6
"""Width of all figures: that of a report's page [inch]."""
THRESHOLD: Look = {"color": "0.2", "lw": 1.0, "ls": "--"}
"""Look of the lines at a threshold."""
