"""How the work of a stage is done: by whom, and who is told of it."""

from apesim.studies.execution.pool import Team


class Work:
    """Tasks of stages, shared by a team.

    Parameters
    ----------
    team : apesim.studies.execution.pool.Team, optional
        Without, all is done in this process.
    tell : callable, optional
        Told of each stage: its name, how far it is, of how much.
    """

    def __init__(self, team=None, tell=None):
        self.team = team or Team()
        self.tell = tell or (lambda stage, done, whole: None)

    def each(self, stage, function, items):
        """Results of a function for tuples of arguments, in order, see `apesim.studies.execution.pool.Team.map`."""
        return self.team.map(function, items, lambda *at: self.tell(stage, *at))
