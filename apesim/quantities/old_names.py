"""Old names: words of files that have another name today, and are still read."""

import warnings


class OldNameWarning(FutureWarning):
    """An old name was read, and taken for the one that it has today."""


def warn_of_old_name(old: str, new: str, reason: str) -> None:
    """Warn by `OldNameWarning` that an old name was read; Python shows the same warning once.

    `reason` says what is different today.
    """
    warnings.warn(f'"{old}" is read as "{new}": {reason}', OldNameWarning, stacklevel=2)
