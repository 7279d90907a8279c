"""Progress of long work: a bar with the time left on standard error, or a call for each step."""

import contextlib
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import rich.progress

Progress = bool | Callable[[int, int], object]
"""False: nothing is shown; True: a bar on standard error; a function: it is called with what is done and with all."""


@contextlib.contextmanager
def show_progress(progress: Progress, task: str) -> Iterator[Callable[[int, int], object]]:
    """Show the progress of a task as it was asked for.

    Parameters
    ----------
    progress : bool or function
        False: nothing is shown; True: a bar on standard error; a function is what is called.
    task : str
        Name of the task, which stands before the bar.

    Yields
    ------
    function
        ``report(done, total)``, to be called with the numbers of points done and in all.

    Examples
    --------
    >>> with show_progress(print, "sweep") as report:
    ...     report(1, 2)
    1 2
    """
    if callable(progress):
        yield progress
        return
    if not progress:
        yield lambda done, total: None
        return
    with progress_bar() as bar:
        line = bar.add_task(task, total=None)
        yield lambda done, total: bar.update(line, completed=done, total=total)


def progress_bar() -> "rich.progress.Progress":
    """Make a bar with the name of what is at work, how much is done, and the time left.

    Returns
    -------
    rich.progress.Progress
        Bar on standard error; a context manager that shows it.

    Examples
    --------
    >>> bar = progress_bar()
    >>> task = bar.add_task("sweep", total=40)
    >>> bar.update(task, completed=10)
    >>> bar.tasks[0].percentage
    25.0
    """
    from rich.console import Console as Terminal
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    name = TextColumn("{task.description}")
    columns = (name, BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("left"))
    return Progress(*columns, console=Terminal(stderr=True))
