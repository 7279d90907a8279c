"""What the paper says of the stroke: its speed and time (Figs. 9 to 11), and that opening is like closing."""

import numpy as np

from studies.paper.claim import Claim, verdict_of


def fluctuation_rises(grid):
    """The velocity fluctuates as pressure rises (Fig. 9)."""
    mean = grid.opening["fluctuation"].mean(axis=1)
    return Claim(
        "fluctuation_over_pressure",
        "Fig. 9",
        "The velocity fluctuates more as the pressure rises.",
        "rises",
        f"{mean[0]:.2f} of the peak speed at 0.1 MPa, {mean[-1]:.2f} at 1.9 MPa",
        {"at_lowest_pressure": mean[0], "at_highest_pressure": mean[-1]},
        verdict_of(mean[-1] > mean[0] and np.polyfit(grid.pressure, mean, 1)[0] > 0.0),
        "Fluctuation: (peak speed - lowest later speed before contact)/peak.",
    )


def piston_rebounds(grid):
    """The piston may even rebound."""
    count = int(grid.opening["reverses"].sum() + grid.closing["reverses"].sum())
    return Claim(
        "rebound",
        "discussion of Fig. 9",
        "At high pressure the piston slows down and even rebounds before it arrives.",
        "rebounds",
        f"turns back in {count} of {2 * grid.opening['reverses'].size} strokes",
        {"strokes_that_turn": count},
        verdict_of(count > 0),
        "Judged by a single stroke of the paper's grid, opening or closing, that turns back before contact.",
    )


def not_monotonic(grid, key, measure, name, unit, factor):
    """A measure that does not only rise or only fall with pressure (Figs. 10, 11)."""
    steps = np.diff(grid.opening[measure], axis=0) * factor
    mixed = int(np.sum(~(np.all(steps > 0.0, axis=0) | np.all(steps < 0.0, axis=0))))
    ends = grid.opening[measure][[0, -1]].mean(axis=1) * factor
    return Claim(
        key,
        "Figs. 10, 11",
        f"The {name} does not change in one direction only as the pressure rises.",
        "not monotonic",
        f"not monotonic at {mixed} of {steps.shape[1]} temperatures; {ends[0]:.2f} {unit} at 0.1 MPa, "
        f"{ends[1]:.2f} {unit} at 1.9 MPa",
        {"temperatures_not_monotonic": mixed, "at_lowest_pressure": ends[0], "at_highest_pressure": ends[1]},
        verdict_of(mixed > 0),
        "Of the opening stroke.",
    )


def stroke_time_falls_with_temperature(grid):
    """t_f falls with T_0."""
    steps = np.diff(grid.opening["stroke_time_s"], axis=1) * 1e3
    return Claim(
        "stroke_time_over_temperature",
        "Fig. 10",
        "At constant pressure the full stroke time falls as the temperature rises.",
        "falls",
        f"changes by {steps.min():+.3f} to {steps.max():+.3f} ms a step of 8 K, over all pressures",
        {"lowest_step_ms": steps.min(), "highest_step_ms": steps.max()},
        verdict_of(np.all(steps < 0.0)),
        "The same square root that the paper's delay time contradicts.",
    )


def strokes_alike(grid):
    """Opening and closing are almost the same."""
    shares = [
        np.abs(grid.closing[m] / grid.opening[m] - 1.0) for m in ("delay_s", "stroke_time_s", "seating_speed_m_s")
    ]
    least, most = min(s.min() for s in shares), max(s.max() for s in shares)
    return Claim(
        "opening_and_closing_alike",
        "simulation analysis",
        "Opening and closing are almost the same, as the valve is symmetric.",
        "almost the same",
        f"differ by {least * 100:.1f} to {most * 100:.1f} % after a rest",
        {"least_difference": least, "largest_difference": most},
        verdict_of(most < 0.1),
        "Judged by a tenth. After a rest the chambers start from unlike states; in periodic full-stroke operation the "
        "strokes coincide.",
    )
