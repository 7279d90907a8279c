"""LSODA with root finding, from one corner or change of the piston's phase to the next."""

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from .piston import CLOSED, CLOSING, OPEN, OPENING, POSITION, SPEED, after, exits

RELATIVE = 1e-9


class Contact(NamedTuple):
    """The piston meets a stop."""

    at: float
    stop: str
    speed: float
    """Just before [m/s]."""


class Crossing(NamedTuple):
    """The piston passes a position under way."""

    at: float
    position: float
    """[m]"""
    direction: int


class March(NamedTuple):
    """A march over x, be it time or crank angle."""

    x: float
    y: np.ndarray
    phase: str
    pieces: tuple
    """Start and dense solution of each smooth stretch."""
    contacts: tuple
    crossings: tuple

    def states(self, xs):
        """States at the given x; shape (states, n)."""
        starts = [start for start, _ in self.pieces]
        which = np.searchsorted(starts, xs, side="right") - 1
        found = np.empty((len(self.y), len(xs)))
        for i in np.unique(which):
            found[:, which == i] = self.pieces[i][1](np.asarray(xs)[which == i])
        return found


def march(valve, rates, push, corners, x, y, phase, absolute, longest, levels=(), relative=RELATIVE):
    """March from corner to corner.

    Parameters
    ----------
    valve : truth.simulator.valve.Bench
    rates : callable
        dy/dx of x, y and phase.
    push : callable or None
        On the piston, of x and y, see `truth.simulator.piston.exits`. None: there is no piston.
    corners : list of float
        Where the rates are not smooth, ascending; the last is the end.
    x : float
    y : (n,) float array
    phase : str
    absolute : (n,) float array
        Tolerance.
    longest : float
        Step.
    levels : tuple of float
        Positions whose crossings are noted [m].
    relative : float
        Tolerance.

    Returns
    -------
    March
    """
    pieces, contacts, crossings = [], [], []
    while x < corners[-1]:
        end = next(at for at in corners if at > x)
        ends = exits(valve, push, phase) if push else []
        noted = levels if phase in (OPENING, CLOSING) else ()
        watched = [event(function, direction, True) for function, direction in ends]
        watched += [event(lambda x, y, level=level: y[POSITION] - level, 0, False) for level in noted]
        piece = solve_ivp(
            lambda x, y, phase=phase: rates(x, y, phase),
            (x, end),
            y,
            method="LSODA",
            rtol=relative,
            atol=absolute,
            max_step=longest,
            dense_output=True,
            events=watched,
        )
        if piece.status < 0:
            raise ArithmeticError(piece.message)
        pieces.append((x, piece.sol))
        for level, at, states in zip(noted, piece.t_events[len(ends) :], piece.y_events[len(ends) :], strict=True):
            crossings += [Crossing(float(t), level, int(np.sign(s[SPEED]))) for t, s in zip(at, states, strict=True)]
        x, y = float(piece.t[-1]), piece.y[:, -1].copy()
        if piece.status == 1:
            which = next(i for i, at in enumerate(piece.t_events) if len(at) and at[-1] == x)
            if phase in (OPENING, CLOSING) and which == 0:
                contacts.append(Contact(x, OPEN if phase == OPENING else CLOSED, abs(float(y[SPEED]))))
            phase = after(valve, push, phase, which, x, y)
    return March(x, y, phase, tuple(pieces), tuple(contacts), tuple(crossings))


def event(function, direction, terminal):
    """A function as solve_ivp wants its events."""
    function.direction, function.terminal = direction, terminal
    return function
