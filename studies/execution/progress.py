"""Progress of long work: a bar with the time left on standard error, or a call for each step."""

import contextlib
import html
import sys
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import rich.progress

LINES_AFTER = 5.0
"""Time from which work is told in lines [s]: shorter work needs none."""
DRAWN_EVERY = 0.2
"""Time between two drawings of a bar in a notebook [s]."""
LINE_EVERY = 30.0
"""Time after which a stage that goes on is told again [s]."""

Progress = bool | Callable[[int, int], object]
"""False: nothing is shown; True: a bar on standard error; a function: it is called with what is done and with all."""


@contextlib.contextmanager
def show_progress(progress: Progress, task: str) -> Iterator[Callable[[int, int], object]]:
    """Show the progress of a task as it was asked for.

    False: nothing is shown; True: a bar on standard error; a function is what is called. `task` is the name that stands
    before the bar. Yields ``report(done, total)``, to be called with the numbers of points done and in all.

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
    if _is_notebook():
        yield _NotebookBar(task).report
        return
    with progress_bar() as bar:
        line = bar.add_task(task, total=None)
        yield lambda done, total: bar.update(line, completed=done, total=total)


def _is_notebook() -> bool:
    """Whether a notebook's kernel runs this, whose output is no terminal."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and hasattr(shell, "kernel")


class _NotebookBar:
    """Bar below a cell of a notebook, drawn by the browser: it needs no widgets."""

    def __init__(self, task: str) -> None:
        from IPython.display import display

        self._task, self._begin, self._last = task, time.perf_counter(), 0.0
        self._handle = display(self._page(0, 0, 0.0), raw=True, display_id=True)

    def report(self, done: int, total: int) -> None:
        """Draw what is done, and the time left."""
        took = time.perf_counter() - self._begin
        if done < total and took - self._last < DRAWN_EVERY:
            return
        self._last = took
        self._handle.update(self._page(done, total, took), raw=True)

    def _page(self, done: int, total: int, took: float) -> dict[str, str]:
        """The bar as HTML and as text."""
        left = f", some {took / done * (total - done):.0f} s left" if 0 < done < total else ""
        text = f"{self._task}: {done} of {total}{left}" if total else self._task
        share = f' value="{done}" max="{total}"' if total else ""
        return {"text/plain": text, "text/html": f"<progress{share}></progress> {html.escape(text)}"}


@contextlib.contextmanager
def write_stages(stage: str, tell: Callable[[str], object]) -> Iterator[Callable[[str, int, int], object]]:
    """Tell the progress of work in stages in lines, for a stream that is no terminal: one a stage, with its time.

    A stage that takes long is told of every `LINE_EVERY` as well. Nothing is told of work that ends within
    `LINES_AFTER`. `stage` is the name of the first stage; `tell` is called with each line. Yields ``report(stage, done,
    total)``, to be called with the name of the stage, what is done of it and what there is.
    """
    lines = _StageLines(stage, tell)
    yield lines.report
    lines.end_stage()


class _StageLines:
    """Lines of `write_stages`; those of the first seconds wait until the work has proved to be long."""

    def __init__(self, stage: str, tell: Callable[[str], object]) -> None:
        self._tell = tell
        self._stage, self._done, self._total = stage, 0, 0
        self._begin = self._stage_begin = self._last = time.perf_counter()
        self._waiting: list[str] = []

    def report(self, stage: str, done: int, total: int) -> None:
        """Take note of what is done, and tell what is due."""
        now = time.perf_counter()
        if stage != self._stage:
            self.end_stage()
            self._stage, self._stage_begin, self._last = stage, now, now
        self._done, self._total = done, total
        if now - self._last > LINE_EVERY:
            took = now - self._stage_begin
            left = f", some {took / done * (total - done):.0f} s left" if 0 < done <= total else ""
            self._say(f"{stage}: {done} of {total} after {took:.0f} s{left}")
            self._last = now

    def end_stage(self) -> None:
        """Tell how long the stage took; nothing of one of which nothing was done."""
        took = time.perf_counter() - self._stage_begin
        if self._done or took > LINES_AFTER:
            self._say(f"{self._stage}: {took:.1f} s")
        self._done = 0

    def _say(self, line: str) -> None:
        self._waiting.append(line)
        if time.perf_counter() - self._begin > LINES_AFTER:
            for each in self._waiting:
                self._tell(each)
            self._waiting.clear()


def progress_bar() -> "rich.progress.Progress":
    """Make a bar on standard error with the name of what is at work, how much is done, and the time left.

    It is a context manager that shows it.
    """
    from rich.console import Console as Terminal
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    name = TextColumn("{task.description}")
    columns = (name, BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("left"))
    return Progress(*columns, console=Terminal(stderr=True))
