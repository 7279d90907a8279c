"""The valve on its bench in steps, its command and its supply changed in between."""

from typing import Any, NamedTuple

import numpy as np

from apesim.air import GasState
from apesim.march.adaptive import TOLERANCE
from apesim.march.stepping import Stepping, Steps
from apesim.valve.bench import TRACE, Bench, accuracy_of, bench_of, closed_at_start, closure
from apesim.valve.edges import EDGES, FAR, add_edge, len_of_ramps


class BenchSteps(NamedTuple):
    """State of the bench between two steps, see `apesim.march.stepping.Steps`."""

    steps: Steps
    """State of the march."""
    p: Bench
    """Bench with the supply of the moment."""
    edges: np.ndarray
    """Edges of the command so far [s], (EDGES,), inf where there is none."""
    breakpoints: np.ndarray
    """Corners of the solenoids that follow from them [s]."""
    command: int
    """1: energised, 0: released."""


class BenchStepping(Stepping):
    """March of a machine's valve on its bench in steps, from rest, closed and released.

    The tolerance is the relative error of a step of the march.

    >>> import apesim
    >>> stepping = BenchStepping(apesim.Machine())
    >>> stepping.switch(1)
    >>> outcome = stepping.march_to(8e-3)
    >>> round(float(stepping.row[0]) * 1e3, 2)  # the lift [mm]
    3.18
    """

    def __init__(self, machine: Any, tolerance: float = TOLERANCE) -> None:
        self.edges, self.command = np.full(EDGES, np.inf), 0
        p, tables = bench_of(machine, self.edges)
        y, mode = closed_at_start(p)
        super().__init__(p, tables, y, mode, np.array([FAR]), accuracy_of(p, tolerance), len(TRACE))
        self.tables = tables._replace(edges_a=self.edges, edges_b=self.edges)

    def switch(self, command: int) -> None:
        """Energise (1) or release (0) the solenoids now, where they are not so already."""
        if command != self.command:
            self.command = command
            add_edge(self.edges, self.time, len_of_ramps(self.tables))
            self.breakpoints = self.tables.breakpoints(self.time, FAR)
            self.begin_stretch()

    def feed(self, pressure: float | None = None, temperature: float | None = None) -> None:
        """Change pressure [Pa abs] and temperature [K] of the control air; what is None stays.

        Dead times that an effect has made from the pressure stay those of the start.
        """
        before = self.p.supply.control
        now = GasState(
            before.pressure if pressure is None else float(pressure),
            before.temperature if temperature is None else float(temperature),
        )
        if now != before:
            self.p = self.p._replace(supply=self.p.supply._replace(control=now))
            self.begin_stretch()

    def closure(self) -> dict[str, float]:
        """Return the mass and energy that are not accounted for since the start, relative to what was supplied."""
        told = closure(self.start, self.y, 0.0)
        return {name: float(told[name]) for name in ("mass", "energy")}

    def copy_all(self) -> BenchSteps:
        """Copy the state between two steps."""
        return BenchSteps(self.steps(), self.p, self.edges.copy(), self.breakpoints, self.command)

    def restore(self, kept: BenchSteps) -> None:
        """Go back to a state that was copied."""
        self.put_back(kept.steps)
        self.p, self.edges[:] = kept.p, kept.edges
        self.breakpoints, self.command = kept.breakpoints, kept.command
