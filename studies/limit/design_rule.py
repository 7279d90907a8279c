"""Design rule of the limit: from lap to lap the valve needs one time, whatever the window between its targets."""

from collections.abc import Hashable, Sequence
from math import nan
from typing import Any, NamedTuple

import numpy as np

from apesim.archive import Variable
from apesim.archive.columns import column
from apesim.engine.angles import DEGREE, RPM

WITHIN = 0.5 * DEGREE
"""Angle by which the opening and the closing may miss their targets [rad]."""
MAX_WINDOW = 150.0 * DEGREE
"""Longest window that the rule is fitted to [rad]. Beyond, the valve is short of time closed: of the default machine
the time from lap to lap is the same within 0.1 % for windows of 20 to 140 deg, 0.9 % longer at 160 deg and 6 % at
240 deg, and from 320 deg on the piston does not reach its closed stop in time."""
PAPER_RPM = {"30 Hz, one event a revolution": 1800.0, "as printed": 2000.0}
"""Speeds that the EPV paper (doi 10.1631/jzus.A0820373) claims [r/min]."""
FORMULA = "limit [r/min] = (window [deg] + 1)/(6 t [s])"
"""The rule in words, each end of the window met within 0.5 deg."""


class DesignRule(NamedTuple):
    """Limit of the valve at one supply, as a law of the window between opening and closing."""

    lap_to_lap: float
    """Time for which the lift has to be above the lap [s]; NaN: no limit to fit it to."""

    def limit(self, window: Any) -> Any:
        """Find the highest speed [rad/s] at which a window is served, each end of it met within `WITHIN`.

        The window is the crank angle from opening to closing [rad], a float or an array.
        """
        return (window + 2.0 * WITHIN) / self.lap_to_lap

    def window(self, speed: float) -> float:
        """Find the shortest window that is served at a speed [rad/s], each end of it met within `WITHIN`.

        The window is the crank angle from opening to closing [rad].
        """
        return speed * self.lap_to_lap - 2.0 * WITHIN


def fit_rule(windows: np.ndarray, limits: np.ndarray) -> DesignRule:
    """Fit the design rule to limits at one supply, by least squares of the speeds.

    `windows` (n,) are crank angles from opening to closing [rad], `limits` (n,) the highest speed for each [rad/s]; the
    rule's time is NaN where there are no limits.
    """
    spans = np.asarray(windows) + 2.0 * WITHIN
    return DesignRule(float(spans @ spans / (spans @ limits)) if len(spans) else nan)


def rule_columns(
    supplies: Sequence[Hashable], windows: np.ndarray, limits: np.ndarray, by_full_lift: np.ndarray
) -> dict[str, Variable]:
    """Make the columns of an archive that say what the design rule, fitted supply by supply, predicts at each point.

    They are whether the rule is fitted to a point, its time, its limit and the window that 30 Hz need. `supplies` holds
    the air of each of n points, and points of equal air share a rule; `windows` (n,) are crank angles from opening to
    closing [rad], `limits` (n,) highest speeds [rad/s], NaN where there is none. The rule is fitted only to points of
    `by_full_lift` (n,), where the valve fails to lift fully above the limit.
    """
    fitted = by_full_lift & (windows <= MAX_WINDOW) & ~np.isnan(limits)
    alike = np.array([[one == other for other in supplies] for one in supplies])
    rules = [fit_rule(windows[fitted & equal], limits[fitted & equal]) for equal in alike]
    paper = PAPER_RPM["30 Hz, one event a revolution"]

    return {
        "rule_fitted": column(fitted, "1", "whether the design rule is fitted to this point"),
        "rule_lap_to_lap_s": column(
            [rule.lap_to_lap for rule in rules], "s", "time from lap to lap that the design rule needs at this supply"
        ),
        "rule_limit_rpm": column(
            [rule.limit(window) / RPM for rule, window in zip(rules, windows, strict=True)],
            "r/min",
            f"limit by the design rule, revolutions a minute: {FORMULA}",
        ),
        "rule_window_deg": column(
            [rule.window(paper * RPM) / DEGREE for rule in rules],
            "deg",
            f"window that {paper:g} r/min (30 Hz) need by the design rule at this supply",
        ),
    }
