"""What a machine registers, for the type of its parameters, to be marched.

The state ``y`` holds the integrated states first, and behind them the ledger: quantities that are integrated
beside the states and act on nothing. ``mode`` holds what jumps between smooth stretches and is constant within one:
the phase of a contact, the piece of a table in use. A machine's parameters ``p`` are numbers only; its arrays travel
apart, as ``tables``, and are looked at on entering a stretch: a reference counted array in a tuple that is handed
from law to law costs more than the laws.
"""

from apesim.kernel import by_type


@by_type(required=True)
def rates(p, t, y, mode, dy):
    """Write dy/dt into dy; False where the state has left its domain."""


@by_type
def events(p, t, y, mode, g):
    """Write into g what ends a step where it rises above zero: contacts, lift-offs, corners of a table."""


@by_type
def handle_event(p, tables, event, t, y, mode):
    """Change y and mode at an event."""


@by_type
def zero_crossings(p, t, y, dy, mode, w):
    """Write into w what is located where it changes its sign, and noted, without ending a step."""


@by_type
def start_segment(p, tables, t, t_end, y, mode):
    """Set mode on entering the smooth stretch from t to t_end."""


@by_type
def power(p, t, y):
    """The power whose integral is also taken by quadrature of the dense output [W]."""
    return 0.0


@by_type
def observe(p, t, y, mode, row):
    """Write one row of a trace."""
