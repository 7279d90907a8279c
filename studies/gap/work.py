"""The work of a stage: the processes that share it, and the progress that is reported."""

from collections.abc import Callable, Iterable
from typing import Any

from apesim.studies.estimation.residuals import Counter
from apesim.studies.execution.pool import Team


class Work:
    """Tasks of stages, shared by the processes of a team.

    Parameters
    ----------
    team : apesim.studies.execution.pool.Team, optional
        Processes that share the tasks; without it, all is done in this process.
    tell : callable, optional
        Called with the name of a stage, the number of its tasks that are done, and their number in all.

    Attributes
    ----------
    simulations : apesim.studies.estimation.residuals.Counter
        Counter of the simulations of all stages, of one run each.

    Examples
    --------
    >>> Work().each("adding", max, [(1, 2), (4, 3)])
    [2, 4]
    """

    def __init__(self, team: Team | None = None, tell: Callable[[str, int, int], object] | None = None) -> None:
        self.team = team or Team()
        self.tell = tell or (lambda stage, done, whole: None)
        self.simulations = Counter()

    def each(self, stage: str, function: Callable[..., Any], items: Iterable[tuple[Any, ...]]) -> list[Any]:
        """Call a function with each of several tuples of arguments, and report the progress of the stage.

        Parameters
        ----------
        stage : str
            Name of the stage, for the report.
        function : callable
            A function of a module, as other processes have to find it.
        items : iterable of tuple
            Arguments of each call.

        Returns
        -------
        list
            Results in the order of the items; see `apesim.studies.execution.pool.Team.map`.

        Examples
        --------
        >>> Work(tell=print).each("adding", max, [(1, 2), (4, 3)])
        adding 1 2
        adding 2 2
        [2, 4]
        """
        return self.team.map(function, items, lambda *at: self.tell(stage, *at))
