"""Hybrid system: what a machine registers, for the type of its parameters, to be marched.

The state ``y`` holds the integrated states first, and behind them the ledger: quantities that are integrated
beside the states and act on nothing. ``mode`` holds what jumps between smooth stretches and is constant within one:
the phase of a contact, the piece of a table in use. A machine's parameters ``p`` are numbers only; its arrays travel
apart, as ``tables``, and are looked at on entering a stretch: a reference counted array in a tuple that is handed
from law to law costs more than the laws.

Systems that flow and jump: Goebel, Sanfelice and Teel, Hybrid dynamical systems, IEEE Control Systems Magazine 29,
2009, 28, doi 10.1109/MCS.2008.931718.
"""

from typing import Any

import numpy as np

from apesim.kernel import by_type

MAX_SHORT_STEPS = 300
"""Explicit steps of one smooth stretch that stability holds far below the longest; with more it is stiff. Chosen."""


@by_type(required=True)
def rates(p: Any, t: float, y: np.ndarray, mode: np.ndarray, dy: np.ndarray) -> Any:
    """Write the rates of states and ledger, ``dy/dt``; every machine has to register its own.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    t : float
        Time [s].
    y : (m,) float array
        State and ledger.
    mode : (k,) float array
        Modes of the machine.
    dy : (m,) float array
        Rates; filled.

    Returns
    -------
    bool
        Whether the state lies in the domain of the laws.

    Examples
    --------
    A machine that decays at 2 per second:

    >>> from typing import NamedTuple
    >>> import numpy as np
    >>> from apesim.kernel import kernel
    >>> from apesim.march.hybrid_system import rates
    >>> class Decay(NamedTuple):
    ...     rate: float
    >>> @rates.for_type(Decay)
    ... @kernel
    ... def decay_rates(p, t, y, mode, dy):
    ...     dy[0] = -p.rate * y[0]
    ...     return True
    >>> p, y, mode = Decay(rate=2.0), np.array([1.0]), np.zeros(1)
    >>> dy = np.empty(1)
    >>> rates(p, 0.0, y, mode, dy), dy.tolist()
    (True, [-2.0])
    """


@by_type
def events(p: Any, t: float, y: np.ndarray, mode: np.ndarray, g: np.ndarray) -> None:
    """Write values that end a step where they rise above zero: contacts, lift-offs, corners of a table.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    t : float
        Time [s].
    y : (m,) float array
        State and ledger.
    mode : (k,) float array
        Modes of the machine.
    g : (EVENTS,) float array
        Values of the events, -1 before; filled.

    Examples
    --------
    A machine that registers none has no events:

    >>> g = np.full(16, -1.0)
    >>> events((), 0.0, np.zeros(1), np.zeros(1), g)
    >>> float(g.max())
    -1.0
    """


@by_type
def handle_event(p: Any, tables: Any, event: int, t: float, y: np.ndarray, mode: np.ndarray) -> None:
    """Change state and modes at an event.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    tables : NamedTuple
        Arrays of the machine.
    event : int
        Number of the event.
    t : float
        Time [s].
    y : (m,) float array
        State and ledger.
    mode : (k,) float array
        Modes of the machine.

    Examples
    --------
    A machine that registers none stays as it is:

    >>> y = np.ones(1)
    >>> handle_event((), (), 0, 0.0, y, np.zeros(1))
    >>> y.tolist()
    [1.0]
    """


@by_type
def zero_crossings(p: Any, t: float, y: np.ndarray, dy: np.ndarray, mode: np.ndarray, w: np.ndarray) -> None:
    """Write values that are located and noted where they change their sign, without ending a step.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    t : float
        Time [s].
    y : (m,) float array
        State and ledger.
    dy : (m,) float array
        Rates.
    mode : (k,) float array
        Modes of the machine.
    w : (n,) float array
        Values, 0 before, as many as there are events; filled.

    Examples
    --------
    A machine that registers none has no zero crossings:

    >>> w = np.zeros(16)
    >>> zero_crossings((), 0.0, np.zeros(1), np.zeros(1), np.zeros(1), w)
    >>> float(np.abs(w).max())
    0.0
    """


@by_type
def start_segment(p: Any, tables: Any, t: float, t_end: float, y: np.ndarray, mode: np.ndarray) -> None:
    """Set the modes on entering a smooth stretch.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    tables : NamedTuple
        Arrays of the machine.
    t, t_end : float
        Start and end of the stretch [s].
    y : (m,) float array
        State and ledger.
    mode : (k,) float array
        Modes of the machine.

    Examples
    --------
    A machine that registers none keeps its modes:

    >>> mode = np.ones(1)
    >>> start_segment((), (), 0.0, 1.0, np.zeros(1), mode)
    >>> mode.tolist()
    [1.0]
    """


@by_type
def step_share(p: Any, y: np.ndarray, mode: np.ndarray) -> float:
    """Return how long a step may be from a state, as a share of the longest step of the march.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    y : (m,) float array
        State and ledger.
    mode : (k,) float array
        Modes of the machine.

    Returns
    -------
    float
        Share, above 0; 1 for a machine that registers none.

    Examples
    --------
    >>> step_share((), np.zeros(1), np.zeros(1))
    1.0
    """
    return 1.0


@by_type
def power(p: Any, t: float, y: np.ndarray) -> float:
    """Return the power whose integral is also taken by quadrature of the dense output.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    t : float
        Time [s].
    y : (m,) float array
        State and ledger.

    Returns
    -------
    float
        Power; 0 for a machine that registers none [W].

    Examples
    --------
    >>> power((), 0.0, np.zeros(1))
    0.0
    """
    return 0.0


@by_type
def observe(p: Any, t: float, y: np.ndarray, mode: np.ndarray, row: np.ndarray) -> None:
    """Write one row of a trace.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    t : float
        Time [s].
    y : (m,) float array
        State and ledger.
    mode : (k,) float array
        Modes of the machine.
    row : (q,) float array
        Row of the trace; filled.

    Examples
    --------
    A machine that registers none leaves the row as it is:

    >>> row = np.zeros(2)
    >>> observe((), 0.0, np.zeros(1), np.zeros(1), row)
    >>> row.tolist()
    [0.0, 0.0]
    """


@by_type
def event_count(p: Any) -> int:
    """Return how many events a machine has at most.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.

    Returns
    -------
    int
        Number of events; 17 for a machine that registers none.

    Examples
    --------
    >>> event_count(())
    17
    """
    return 17


@by_type
def segment_end(p: Any, tables: Any, t: float, breakpoint: float, mode: np.ndarray) -> float:
    """Return when the smooth stretch that lasts at a time ends at the latest: the next breakpoint, or before it [s].

    It is asked for as a stretch begins, and after every event: an event may bring an end with it that was not foreseen.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    tables : NamedTuple
        Arrays of the machine.
    t : float
        Time [s].
    breakpoint : float
        Next breakpoint of the march [s].
    mode : (k,) float array
        Modes of the machine; may be changed.

    Returns
    -------
    float
        Time, not before `t`; the breakpoint for a machine that registers none [s].

    Examples
    --------
    >>> segment_end((), (), 0.0, 1.0, np.zeros(1))
    1.0
    """
    return breakpoint


@by_type
def finish_step(
    p: Any, t: float, h: float, y: np.ndarray, dy: np.ndarray, y_end: np.ndarray, dy_end: np.ndarray, mode: np.ndarray
) -> None:
    """Look at an accepted step, to keep extremes: it may change what the ledger holds at its end, and no state.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    t, h : float
        Start and length of the step [s].
    y, dy : (m,) float array
        State and ledger at its start, and their rates.
    y_end, dy_end : (m,) float array
        State and ledger at its end, which may be changed, and their rates.
    mode : (k,) float array
        Modes of the machine.

    Examples
    --------
    A machine that registers none keeps nothing:

    >>> y_end = np.ones(1)
    >>> finish_step((), 0.0, 1.0, np.zeros(1), np.ones(1), y_end, np.ones(1), np.zeros(1))
    >>> y_end.tolist()
    [1.0]
    """


@by_type
def is_final(p: Any, event: int, mode: np.ndarray) -> bool:
    """Return whether an event, once handled, ends the march.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    event : int
        Number of the event.
    mode : (k,) float array
        Modes of the machine.

    Returns
    -------
    bool
        False for a machine that registers none.

    Examples
    --------
    >>> is_final((), 0, np.zeros(1))
    False
    """
    return False


@by_type
def is_followed(p: Any) -> bool:
    """Return whether a march that notes follows zero crossings and the power, too; False spares time.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.

    Returns
    -------
    bool
        True for a machine that registers none.

    Examples
    --------
    >>> is_followed(())
    True
    """
    return True


@by_type
def max_short_steps(p: Any) -> int:
    """Return after how many short steps of a smooth stretch a machine's march counts as stiff.

    An implicit step takes an evaluation of the rates for each state: with many states it pays later.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.

    Returns
    -------
    int
        Number of steps; `MAX_SHORT_STEPS` for a machine that registers none.

    Examples
    --------
    >>> max_short_steps(())
    300
    """
    return MAX_SHORT_STEPS
