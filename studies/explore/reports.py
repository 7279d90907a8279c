"""Reports that the page hands on: the machine over speed, beside the ideal valve, as pages that stand alone."""

import secrets

from apesim.engine.angles import TURN
from apesim.engine.cylinder import IDEAL_VALVE, INTAKES
from apesim.studies.explore.requests import Request

SPEEDS = tuple(range(300, 2401, 300))
"""Speeds of a report [r/min], beside the one that is shown."""
MAX_REPORTS = 8
"""Reports that are kept, the newest: a page of each may be open."""
TOKEN_BYTES = 16
"""Length of the name of a report, which nobody guesses."""


def write_report_of(request: Request) -> str:
    """Run a machine over speed, beside the ideal valve, and write the page of it."""
    from apesim.studies.report.page import render_page
    from apesim.studies.sweep.study import sweep

    shown = float(f"{request.speed / TURN * 60.0:.10g}")
    speeds = [(float(speed), "rpm") for speed in sorted({*map(float, SPEEDS), shown})]
    intakes = dict.fromkeys((INTAKES[request.machine.engine.intake], INTAKES[IDEAL_VALVE]))
    return render_page(sweep(request.machine, speeds, intake=list(intakes), timing="fixed"))


class Reports:
    """The newest reports, by names that nobody guesses."""

    def __init__(self) -> None:
        self._pages: dict[str, str] = {}

    def keep(self, page: str) -> str:
        """Keep a page, and give its name; the oldest is let go where there are too many."""
        name = secrets.token_urlsafe(TOKEN_BYTES)
        self._pages[name] = page
        while len(self._pages) > MAX_REPORTS:
            del self._pages[next(iter(self._pages))]
        return name

    def find(self, name: str) -> str | None:
        """Give the page of a name; None where there is none."""
        return self._pages.get(name)
