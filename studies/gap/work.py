"""How the work of a stage is done: by whom, and who is told of it."""

from apesim.studies.pool import Team


class Work:
    """Tasks of stages, shared by a team.

    Parameters
    ----------
    team : apesim.studies.pool.Team, optional
        Without, all is done in this process.
    tell : callable, optional
        Told of each stage: its name, how far it is, of how much.
    """

    def __init__(self, team=None, tell=None):
        self.team = team or Team()
        self.tell = tell or (lambda stage, done, whole: None)

    def each(self, stage, function, items):
        """What a function makes of tuples of arguments, in their order, see `apesim.studies.pool.Team.map`."""
        return self.team.map(function, items, lambda *at: self.tell(stage, *at))
