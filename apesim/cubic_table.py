"""Tables among the parameters of an effect: values at fixed places, each a strength of its own, cubic in between.

They stand for what has no name yet. A value of 0 does nothing at its place.
"""

from collections.abc import Sequence
from typing import Annotated, Any, NamedTuple

from apesim.kernel import kernel


def table(name: str, module: str, **branches: tuple[Sequence[int | str], Any]) -> Any:
    """Make the NamedTuple type of a table's values, all 0.0 by default: one field ``branch_at_place`` for each value.

    Each branch is given as its places and the `Quantity` of its values. The type has to be assigned to `name` in
    `module`, where the compile cache finds it again.
    """
    fields = [
        (f"{branch}_at_{place}", Annotated[float, quantity])
        for branch, (places, quantity) in branches.items()
        for place in places
    ]
    found: Any = NamedTuple(name, fields)  # type: ignore[misc]  # its name and fields are computed
    found.__new__.__defaults__ = (0.0,) * len(fields)
    found.__module__ = module
    return found


@kernel
def between(before: float, one: float, other: float, after: float, share: float) -> float:
    """Return Catmull and Rom's cubic between two values; the slope at each is that from neighbour to neighbour.

    The cubic is the one of Catmull and Rom [1]_ for equally spaced places.

    Parameters
    ----------
    before, one, other, after : float
        Values at four equally spaced places; the cubic goes from the second to the third.
    share : float
        Place between the second and the third, 0...1.

    Returns
    -------
    float
        Value there.

    References
    ----------
    .. [1] E. Catmull and R. Rom, "A class of local interpolating splines", in "Computer Aided Geometric Design",
       Academic Press, 1974, pp. 317-326, doi 10.1016/B978-0-12-079050-0.50020-5.

    Examples
    --------
    >>> between(0.0, 1.0, 2.0, 3.0, 0.5), between(0.0, 0.0, 1.0, 0.0, 0.5)
    (1.5, 0.5625)
    """
    slope, last = 0.5 * (other - before), 0.5 * (after - one)
    bend = 3.0 * (other - one) - 2.0 * slope - last
    return one + share * (slope + share * (bend + share * (2.0 * (one - other) + slope + last)))


@kernel
def interpolate_clamped(values: tuple[float, ...], place: float) -> float:
    """Return the value of a table at a place, constant beyond its ends, and without a corner there.

    Between two places it is the cubic of Catmull and Rom [1]_. Beyond an end the neighbour that the slope there needs
    is mirrored, which makes the slope 0; this is chosen.

    Parameters
    ----------
    values : tuple of float
        Two or more values, at the places 0, 1, ....
    place : float
        Place in units of the distance between two values.

    Returns
    -------
    float
        Value there.

    References
    ----------
    .. [1] E. Catmull and R. Rom, "A class of local interpolating splines", in "Computer Aided Geometric Design",
       Academic Press, 1974, pp. 317-326, doi 10.1016/B978-0-12-079050-0.50020-5.

    Examples
    --------
    >>> interpolate_clamped((1.0, 2.0, 3.0), 1.0), interpolate_clamped((1.0, 2.0, 3.0), 7.0)
    (2.0, 3.0)
    """
    last = len(values) - 1
    inside = min(max(place, 0.0), float(last))
    i = min(int(inside), last - 1)
    one, other = values[i], values[i + 1]
    before = values[i - 1] if i > 0 else other
    after = values[i + 2] if i + 1 < last else one
    return between(before, one, other, after, inside - i)


@kernel
def interpolate_periodic(values: tuple[float, ...], place: float) -> float:
    """Return the value at a place of a table whose first value follows its last.

    Between two places it is the cubic of Catmull and Rom [1]_.

    Parameters
    ----------
    values : tuple of float
        Values at the places 0, 1, ... of a period.
    place : float
        Place in units of the distance between two values.

    Returns
    -------
    float
        Value there.

    References
    ----------
    .. [1] E. Catmull and R. Rom, "A class of local interpolating splines", in "Computer Aided Geometric Design",
       Academic Press, 1974, pp. 317-326, doi 10.1016/B978-0-12-079050-0.50020-5.

    Examples
    --------
    >>> interpolate_periodic((0.0, 1.0, 0.0, -1.0), 5.0), interpolate_periodic((0.0, 1.0, 0.0, -1.0), 3.5)
    (1.0, -0.625)
    """
    count = len(values)
    inside = place % count
    i = min(int(inside), count - 1)
    before = values[i - 1 if i > 0 else count - 1]
    one, other, after = values[i], values[(i + 1) % count], values[(i + 2) % count]
    return between(before, one, other, after, inside - i)
