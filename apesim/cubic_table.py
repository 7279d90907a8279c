"""Tables among the parameters of an effect: values at fixed nodes, each a strength of its own, cubic in between.

They stand for what has no name yet. A node that is 0 does nothing there.
"""

from typing import Annotated, NamedTuple

from apesim.kernel import kernel


def table(name, module, **branches):
    """NamedTuple type of values at nodes; all 0.0, if left out.

    The compile cache finds a type again by the module that it says it is from, and by its name there.

    Parameters
    ----------
    name, module : str
    **branches : tuple
        For each branch of the table its places, sequence of int or str, and the `Quantity` of its values; the value
        at a place is called ``branch_at_place``.

    Returns
    -------
    type
    """
    fields = [
        (f"{branch}_at_{place}", Annotated[float, quantity])
        for branch, (places, quantity) in branches.items()
        for place in places
    ]
    found = NamedTuple(name, fields)
    found.__new__.__defaults__ = (0.0,) * len(fields)
    found.__module__ = module
    return found


@kernel
def between(before, one, other, after, share):
    """Catmull and Rom's cubic from one node to the other: its slopes there are those from neighbour to neighbour."""
    slope, last = 0.5 * (other - before), 0.5 * (after - one)
    bend = 3.0 * (other - one) - 2.0 * slope - last
    return one + share * (slope + share * (bend + share * (2.0 * (one - other) + slope + last)))


@kernel
def interpolate_clamped(values, place):
    """Value at a place among nodes 0, 1, ...; beyond the ends constant, and without a corner there.

    Parameters
    ----------
    values : tuple of float
        Two or more.
    place : float

    Returns
    -------
    float
    """
    last = len(values) - 1
    inside = min(max(place, 0.0), float(last))
    i = min(int(inside), last - 1)
    one, other = values[i], values[i + 1]
    before = values[i - 1] if i > 0 else other
    after = values[i + 2] if i + 1 < last else one
    return between(before, one, other, after, inside - i)


@kernel
def interpolate_periodic(values, place):
    """The same where node 0 follows the last one.

    Parameters
    ----------
    values : tuple of float
    place : float

    Returns
    -------
    float
    """
    count = len(values)
    inside = place % count
    i = min(int(inside), count - 1)
    before = values[i - 1 if i > 0 else count - 1]
    one, other, after = values[i], values[(i + 1) % count], values[(i + 2) % count]
    return between(before, one, other, after, inside - i)
