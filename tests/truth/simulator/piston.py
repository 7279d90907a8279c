"""The phases of the valve's piston: on a stop, under way, or held by dry friction in between.

A phase lasts until a function of the state passes through zero; each knows its direction, so that only the stop ahead
is watched. Position 0 is open, the stroke is closed; positive force and speed point to closed.
"""

CLOSED, OPENING, STUCK, CLOSING, OPEN = "closed", "opening", "stuck", "closing", "open"
DIRECTION = {CLOSED: 0, OPENING: -1, STUCK: 0, CLOSING: 1, OPEN: 0}
POSITION, SPEED = 0, 1
REST = 1e-3
"""A rebound slower than this is none [m/s]."""


def exits(valve, push, phase):
    """What ends a phase.

    Parameters
    ----------
    valve : truth.simulator.valve.Bench
    push : callable
        Of x and y: the force on the piston without a stop's and dry friction's, and what holds it at rest [N].
    phase : str

    Returns
    -------
    list of (callable, int)
        Functions of x and y, and the sign of the slope of the passage through zero that counts.
    """

    def beyond(sign):
        def excess(x, y):
            force, hold = push(x, y)
            return force + sign * hold

        return excess

    opens, closes = (beyond(1.0), -1), (beyond(-1.0), 1)
    if phase == OPENING:
        return [(lambda x, y: y[POSITION], -1), (lambda x, y: y[SPEED], 1)]
    if phase == CLOSING:
        return [(lambda x, y: y[POSITION] - valve.stroke, 1), (lambda x, y: y[SPEED], -1)]
    return {CLOSED: [opens], OPEN: [closes], STUCK: [opens, closes]}[phase]


def after(valve, push, phase, which, x, y):
    """The phase after an exit; y is brought onto the stop and given its speed after the contact.

    Parameters
    ----------
    valve, push, phase
        See `exits`.
    which : int
        Which of the exits it was.
    x : float
    y : float array

    Returns
    -------
    str
    """
    if phase in (CLOSED, OPEN):
        return OPENING if phase == CLOSED else CLOSING
    if phase == STUCK:
        return (OPENING, CLOSING)[which]
    if which == 0:
        y[POSITION] = 0.0 if phase == OPENING else valve.stroke
        y[SPEED] *= -valve.restitution
        if abs(y[SPEED]) > REST:
            return CLOSING if phase == OPENING else OPENING
    y[SPEED] = 0.0
    force, hold = push(x, y)
    if force < -hold and y[POSITION] > 0.0:
        return OPENING
    if force > hold and y[POSITION] < valve.stroke:
        return CLOSING
    return CLOSED if y[POSITION] >= valve.stroke else OPEN if y[POSITION] <= 0.0 else STUCK
