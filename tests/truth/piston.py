"""The phases of the valve's piston: on a stop, under way, or held by dry friction in between.

A phase lasts until a function of the state passes through zero; each knows its direction, so that only the stop ahead
is watched. Position 0 is open, the stroke is closed; positive force and speed point to closed.
"""

CLOSED, OPENING, STUCK, CLOSING, OPEN = "closed", "opening", "stuck", "closing", "open"
DIRECTION = {CLOSED: 0, OPENING: -1, STUCK: 0, CLOSING: 1, OPEN: 0}
POSITION, SPEED = 0, 1
REST = 1e-3
"""A rebound slower than this is none [m/s]."""


def hold(valve):
    """Dry friction at rest [N]."""
    return max(valve.dry_friction, valve.breakaway)


def exits(valve, force, phase):
    """What ends a phase.

    Parameters
    ----------
    valve : truth.valve.Bench
    force : callable
        Force of x and y on the piston, without a stop's and dry friction's [N].
    phase : str

    Returns
    -------
    list of (callable, int)
        Functions of x and y, and the sign of the slope of the passage through zero that counts.
    """
    keep = hold(valve)
    opens = (lambda x, y: force(x, y) + keep, -1)
    closes = (lambda x, y: force(x, y) - keep, 1)
    if phase == OPENING:
        return [(lambda x, y: y[POSITION], -1), (lambda x, y: y[SPEED], 1)]
    if phase == CLOSING:
        return [(lambda x, y: y[POSITION] - valve.stroke, 1), (lambda x, y: y[SPEED], -1)]
    return {CLOSED: [opens], OPEN: [closes], STUCK: [opens, closes]}[phase]


def after(valve, force, phase, which, x, y):
    """The phase after an exit; y is brought onto the stop and given its speed after the contact.

    Parameters
    ----------
    valve, force, phase
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
    push = force(x, y)
    if push < -hold(valve) and y[POSITION] > 0.0:
        return OPENING
    if push > hold(valve) and y[POSITION] < valve.stroke:
        return CLOSING
    return CLOSED if y[POSITION] >= valve.stroke else OPEN if y[POSITION] <= 0.0 else STUCK
