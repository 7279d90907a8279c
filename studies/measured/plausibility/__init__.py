"""Plausibility of measured data: whether they can be what ``measured.toml`` says, before anything is fitted.

A check of a run against the machine is a row of a table: its name, where it applies, the statistic that is compared
with a threshold, and what is said of it. A fault cannot be physics of a rig anywhere near the machine, a warning may be
real, a hint is information.

In the order in which data flow through them: findings (what a check gives), thresholds (all of them, with reasons),
signals (levels, noise, edges), sample_and_hold (rows that repeat a slower sampler), disturbances (single samples, which
are masked), impossible (samples that the machine rules out), misreadings (units and signs that are often confused),
records (one record by itself), expected (what the machine shows), rows (what a row is, and the loop that reads them),
levels (pressures, lift and the others against the machine), motion (when the valve moves), valve_bench, engine_bench
and cylinder_bench (what one bench alone has), benches (the tables of rows), machine_file (whether its numbers are the
rig's), folder (runs against each other), examination (all checks of a folder).
"""

from apesim.studies.measured.plausibility.examination import Examination, examine, refuse_faults
from apesim.studies.measured.plausibility.findings import Check, Finding, Kind, group_findings

__all__ = ["Check", "Examination", "Finding", "Kind", "examine", "group_findings", "refuse_faults"]
