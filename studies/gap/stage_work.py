"""The work of a stage: the processes that share it, and the progress that is reported."""

from collections.abc import Callable, Iterable
from typing import Any

from apesim.studies.estimation.residuals import Counter
from apesim.studies.execution.pool import Team


class Work:
    """Tasks of stages, shared by the processes of a team; without `team`, all is done in this process.

    `tell` is called with the name of a stage, the number of its tasks that are done, and their number in all;
    `simulations` counts the simulations of all stages, of one run each.
    """

    def __init__(self, team: Team | None = None, tell: Callable[[str, int, int], object] | None = None) -> None:
        self.team = team or Team()
        self.tell = tell or (lambda stage, done, whole: None)
        self.simulations = Counter()

    def each(self, stage: str, function: Callable[..., Any], items: Iterable[tuple[Any, ...]]) -> list[Any]:
        """Call a function with each of several tuples of arguments, and report the progress of the stage.

        Results come in the order of `items`, see `apesim.studies.execution.pool.Team.map`; `function` must be one of a
        module, as other processes have to find it.
        """
        return self.team.map(function, items, lambda *at: self.tell(stage, *at))
