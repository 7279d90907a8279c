"""Error bounds: how well a run promises to close. A run that closes worse than one of them says so."""

MAX_CLOSURE = 1e-8
"""Mass or energy that a ledger does not account for, relative. Only rounding is left of it: 1e-15 as a rule,
1.4e-10 at most over 700 random engines, with receivers of up to 1 m3, where most of the air only lies."""
MAX_EXERGY_CLOSURE = 1e-6
"""Exergy that the ledger does not account for, relative to what enters: what is promised of it; 4e-7 at most over 600
random engines."""
MAX_QUADRATURE_CHANGE = 2e-5
"""Work by quadrature against the ledger, relative. Up to this results are promised to agree with reference solutions;
2e-7 at most over the same engines."""
MAX_TOLERANCE_CHANGE = 1e-4
"""Work or air at ten times the tolerance, relative. 394 of these engines were solved at a hundredth of the tolerance,
too: the one above this bound errs by 1.7e-4, all below it by 3.1e-5 at most, and by 5.7e-5 of 400 others."""
MIN_SHARE_MOVED = 1e-6
"""Closure is relative to what flows, or to this share of what the volumes hold, where less than that flows: below it
nothing but rounding flows, which would be compared with itself."""


def closure_of(missing: float, moved: float, held: float) -> float:
    """Return what a ledger does not account for, relative to what flows, or to `MIN_SHARE_MOVED` of what is held.

    All three are masses [kg] or energies [J]; `held` is that of all volumes together.

    >>> closure_of(1e-9, 1e-3, 1e-3), closure_of(0.0, 0.0, 1e-3)
    (1e-06, 0.0)
    """
    return abs(missing) / max(abs(moved), MIN_SHARE_MOVED * held)
