"""A machine that is marched in steps, each to a time that is known only when it comes."""

from typing import Any, NamedTuple

import numpy as np

from apesim.kernel import compiled_for
from apesim.march.adaptive import LOG_HEAD, REACHED, STOP, STRETCH_END, Accuracy, Outcome, Status, begin_carry, march
from apesim.march.hybrid_system import observe


class Steps(NamedTuple):
    """State of a machine between two steps: with the same inputs from here on, it is the same march to the bit."""

    time: float
    """Time that is reached [s]."""
    y: np.ndarray
    """State and ledger."""
    mode: np.ndarray
    """Modes."""
    carry: np.ndarray
    """What the march carries on, see `apesim.march.adaptive`."""
    row: np.ndarray
    """Row of the trace at the end of the last step."""
    start: np.ndarray
    """State and ledger before the first step."""


class Stepping:
    """March of a machine in steps, from a state `y` and its modes on, which are changed.

    Whoever changes what acts on the machine between two steps calls `begin_stretch`. `columns` are those of the trace;
    `log_rows` is the room for breakpoints and events of a step, 0 where they are not noted.

    >>> from apesim.valve.bench import TRACE, accuracy_of, bench_of, closed_at_start
    >>> import apesim
    >>> p, tables = bench_of(apesim.Machine(), [0.0])
    >>> stepping = Stepping(p, tables, *closed_at_start(p), tables.breakpoints(0.0, 1.0), accuracy_of(p), len(TRACE))
    >>> outcome = stepping.march_to(8e-3)
    >>> round(float(stepping.row[0]) * 1e3, 2)  # the lift [mm]
    3.18
    """

    def __init__(
        self,
        p: Any,
        tables: Any,
        y: np.ndarray,
        mode: np.ndarray,
        breakpoints: np.ndarray,
        accuracy: Accuracy,
        columns: int,
        log_rows: int = 0,
    ) -> None:
        self.p, self.tables, self.y, self.mode, self.breakpoints = p, tables, y, mode, breakpoints
        self.accuracy, self.time, self.start = accuracy, 0.0, y.copy()
        self.carry = begin_carry(accuracy)
        self.log = np.empty((log_rows, LOG_HEAD + len(y)))
        self._times, self._rows = np.empty(1), np.zeros((1, columns))
        self.row = self._rows[0]
        observe(p, 0.0, y, mode, self.row)
        self._march = compiled_for(march, *self._arguments())

    def _arguments(self) -> tuple[Any, ...]:
        """Arguments of the march, as they are now."""
        return (
            self.p,
            self.tables,
            self.time,
            self.y,
            self.mode,
            self.breakpoints,
            self.accuracy,
            self.log,
            self._times,
            self._rows,
            self.carry,
        )

    def begin_stretch(self) -> None:
        """Let a smooth stretch begin with the next step, as what acts on the machine has changed."""
        self.carry[STRETCH_END] = -np.inf

    def march_to(self, t: float) -> Outcome:
        """March on to a time [s], at which the row of the trace is taken; to where it fails, if it does."""
        self.carry[STOP] = self._times[0] = t
        outcome: Outcome = self._march(*self._arguments())
        self.time = t
        if outcome.status != Status.DONE:
            self.time = float(self.carry[REACHED])
            observe(self.p, self.time, self.y, self.mode, self.row)
        return outcome

    def steps(self) -> Steps:
        """Copy the state between two steps."""
        return Steps(self.time, self.y.copy(), self.mode.copy(), self.carry.copy(), self.row.copy(), self.start)

    def put_back(self, steps: Steps) -> None:
        """Go back to a state that was copied."""
        self.time, self.start = steps.time, steps.start
        self.y[:], self.mode[:], self.carry[:], self.row[:] = steps.y, steps.mode, steps.carry, steps.row
