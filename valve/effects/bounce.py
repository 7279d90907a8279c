"""Rebound of the piston from its stops."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, Search, contact
from apesim.kernel import kernel
from apesim.quantities import Quantity


class Bounce(NamedTuple):
    """Stops that give back a share of the speed."""

    restitution: Annotated[float, Quantity("", 0, 0.6, "steel on steel, damped")] = 0.0


@contact.for_type(Bounce)
@kernel
def bounce(effect: Bounce, speed: float) -> float:
    """Return the restitution of a stop, ``v+ = -e v-`` (Newton's law of restitution).

    v- and v+ are the speeds before and after the contact, e is the coefficient of restitution [1]_.

    Parameters
    ----------
    effect : Bounce
        Parameters of the effect.
    speed : float
        Speed of the contact without sign [m/s]; e does not depend on it.

    Returns
    -------
    float
        Speed after over speed before contact e, 0...1.

    References
    ----------
    .. [1] W. J. Stronge, "Impact Mechanics", Cambridge University Press, 2000, doi 10.1017/CBO9780511626432.

    Examples
    --------
    >>> bounce(Bounce(restitution=0.3), 2.0)
    0.3
    """
    return effect.restitution


EFFECT = Effect(
    "bounce",
    Bounce,
    equation="v+ = -e v-",
    source="Newton's law of restitution",
    seen_in="rebound at the stops",
    isolated_by="lift sampled at 20 kHz or more around the contact",
    search=Search(sizes=(0.25, 0.5, 0.75, 1.0)),
)
