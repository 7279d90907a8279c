"""Design rule of the limit: from lap to lap the valve needs one time, whatever the window between its targets."""

from collections.abc import Hashable, Sequence
from math import nan
from typing import Any, NamedTuple

import numpy as np

from apesim.archive import Variable
from apesim.archive.columns import column
from apesim.engine.angles import DEGREE, TURN

RPM = TURN / 60.0
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
        """Find the highest speed at which a window is served, each end of it met within `WITHIN`.

        Parameters
        ----------
        window : float or array
            Crank angle from opening to closing [rad].

        Returns
        -------
        float or array
            Speed of the crankshaft [rad/s].

        Examples
        --------
        >>> round(DesignRule(5e-3).limit(75.0 * DEGREE) / RPM, 3)
        2533.333
        """
        return (window + 2.0 * WITHIN) / self.lap_to_lap

    def window(self, speed: float) -> float:
        """Find the shortest window that is served at a speed, each end of it met within `WITHIN`.

        Parameters
        ----------
        speed : float
            Speed of the crankshaft [rad/s].

        Returns
        -------
        float
            Crank angle from opening to closing [rad].

        Examples
        --------
        >>> round(DesignRule(5e-3).window(1800.0 * RPM) / DEGREE, 3)
        53.0
        """
        return speed * self.lap_to_lap - 2.0 * WITHIN


def fit_rule(windows: np.ndarray, limits: np.ndarray) -> DesignRule:
    """Fit the design rule to limits at one supply, by least squares of the speeds.

    Parameters
    ----------
    windows : (n,) float array
        Crank angles from opening to closing [rad].
    limits : (n,) float array
        Highest speed for each window [rad/s].

    Returns
    -------
    DesignRule
        Rule with the fitted time; NaN where there are no limits.

    Examples
    --------
    >>> rule = fit_rule(np.array([60.0, 75.0]) * DEGREE, np.array([2000.0, 2500.0]) * RPM)
    >>> round(rule.lap_to_lap, 6)
    0.005073
    """
    spans = np.asarray(windows) + 2.0 * WITHIN
    return DesignRule(float(spans @ spans / (spans @ limits)) if len(spans) else nan)


def rule_columns(
    supplies: Sequence[Hashable], windows: np.ndarray, limits: np.ndarray, by_full_lift: np.ndarray
) -> dict[str, Variable]:
    """Make the columns of an archive that say what the design rule, fitted supply by supply, predicts at each point.

    Parameters
    ----------
    supplies : sequence of hashable, n of them
        Air of each point; points of equal air share a rule.
    windows : (n,) float array
        Crank angles from opening to closing [rad].
    limits : (n,) float array
        Highest speeds [rad/s]; NaN where there is no limit.
    by_full_lift : (n,) bool array
        Whether the valve fails to lift fully above the limit; the rule is fitted to these points only.

    Returns
    -------
    dict of str to Variable
        Whether the rule is fitted to a point, its time, its limit and the window that 30 Hz need.

    Examples
    --------
    >>> windows, limits = np.array([60.0, 75.0, 200.0]) * DEGREE, np.array([2000.0, 2500.0, 2600.0]) * RPM
    >>> columns = rule_columns(["cold", "cold", "cold"], windows, limits, np.array([True, True, True]))
    >>> columns["rule_fitted"].values.tolist()  # a window of 200 deg is too long
    [1, 1, 0]
    >>> columns["rule_limit_rpm"].values.round(1).tolist()
    [2004.0, 2496.8, 6603.3]
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
