"""Numbers as text, with no more digits than their error leaves."""

from collections.abc import Sequence
from math import ceil, floor, isfinite, log10, sqrt

NORMAL_95 = 1.959963984540054
"""Half the width of a 95 % interval of a standard normal number: its quantile at 0.975."""
MAX_DIGITS = 6
"""Significant digits at most, however small the error is: nobody reads more."""
UNKNOWN_ERROR_DIGITS = 2
"""Significant digits of a number whose error is not known."""


def round_to_error(value: float, error: float | None) -> str:
    """A number as text; its last digit is the first digit of its standard deviation.

    Parameters
    ----------
    value : float
    error : float or None
        Standard deviation, in the unit of the value; None: it is not known, and two digits are shown.

    Returns
    -------
    str

    Examples
    --------
    >>> round_to_error(0.7974, 0.0022), round_to_error(1234.5, 60.0), round_to_error(3.14159, None)
    ('0.797', '1230', '3.1')
    """
    if not isfinite(value) or value == 0.0:
        return f"{value:g}"
    if error is None or not isfinite(error) or error <= 0.0:
        return _write(value, _find_place(value) + 1 - UNKNOWN_ERROR_DIGITS)
    return _write(value, max(_find_place(error), _find_place(value) + 1 - MAX_DIGITS))


def find_error(value: float, interval: Sequence[float] | None, open_ends: Sequence[str]) -> float | None:
    """The standard deviation that a 95 % interval stands for.

    Parameters
    ----------
    value : float
    interval : sequence of float, or None
        Its ends; None: it was not sought.
    open_ends : sequence of str
        Sides on which the data hold nothing: "low", "high".

    Returns
    -------
    float or None
        In the unit of the value; None where it is not known.

    Examples
    --------
    >>> round(find_error(0.7974, [0.793, 0.801], []), 4), find_error(1.0, None, [])
    (0.002, None)
    """
    if interval is None or len(open_ends) == len(interval):
        return None
    low, high = interval
    if not open_ends:
        return (high - low) / (2.0 * NORMAL_95) or None
    held = high if "low" in open_ends else low
    return abs(held - value) / NORMAL_95 or None


def format_size(rms: float, samples: int) -> str:
    """A root mean square over the noise as text: the noise of n samples scatters by 1 / sqrt(2 n).

    Parameters
    ----------
    rms : float
    samples : int
        Samples that it is the mean of.

    Returns
    -------
    str

    Examples
    --------
    >>> format_size(1.0136, 900), format_size(1.0136, 40)
    ('1.01', '1.0')
    """
    return f"{rms:.{min(2, max(0, ceil(log10(2.0 * max(samples, 1)) / 2.0)))}f}"


def format_sigmas(value: float, *, signed: bool = False) -> str:
    """A number of sigmas of the noise as text: a whole number, as noise alone moves it by about one.

    Parameters
    ----------
    value : float
    signed : bool
        Whether a plus is written.

    Returns
    -------
    str

    Examples
    --------
    >>> format_sigmas(247.2), format_sigmas(-0.3, signed=True), format_sigmas(3.8, signed=True)
    ('247', '0', '+4')
    """
    whole = round(value)
    return f"{whole:+d}" if signed and whole else str(whole)


def format_chance(p_value: float, draws: int) -> str:
    """A chance that was counted in random draws, as text; below 1 in 10 000 only that is said.

    Parameters
    ----------
    p_value : float
    draws : int
        Number of draws.

    Returns
    -------
    str

    Examples
    --------
    >>> format_chance(0.0312, 20000), format_chance(3e-6, 20000), format_chance(0.71, 20000)
    ('0.031', 'below 0.0001', '0.71')
    """
    if p_value < 1e-4:
        return "below 0.0001"
    error = sqrt(p_value * max(1.0 - p_value, 1.0 / draws) / draws)
    return _write(p_value, max(_find_place(error), _find_place(p_value) + 1 - UNKNOWN_ERROR_DIGITS))


def _find_place(value: float) -> int:
    """Power of ten of the first digit of a number."""
    return floor(log10(abs(value)) + 1e-9)


def _write(value: float, place: int) -> str:
    """A number rounded to a power of ten, without an exponent where it is of usual size."""
    rounded = round(value, -place)
    if rounded == 0.0:
        return "0"
    if not -5 <= _find_place(rounded) <= MAX_DIGITS:
        return f"{rounded:.{max(0, _find_place(rounded) - place)}e}"
    return f"{rounded:.{max(0, -place)}f}"
