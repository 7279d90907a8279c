"""Old names: words of files that have another name today, and are still read."""

import warnings


class OldNameWarning(FutureWarning):
    """An old name was read, and taken for the one that it has today."""


def warn_of_old_name(old: str, new: str, reason: str) -> None:
    """Warn by `OldNameWarning` that an old name was read; Python shows the same warning once.

    Parameters
    ----------
    old : str
        Name that was read.
    new : str
        Name that it has today.
    reason : str
        What is different today.

    Examples
    --------
    >>> with warnings.catch_warnings(record=True) as caught:
    ...     warnings.simplefilter("always")
    ...     warn_of_old_name("receiver", "vessel", "its wall is no longer adiabatic")
    >>> print(caught[0].message)
    "receiver" is read as "vessel": its wall is no longer adiabatic
    """
    warnings.warn(f'"{old}" is read as "{new}": {reason}', OldNameWarning, stacklevel=2)
