"""The EPV paper (doi 10.1631/jzus.A0820373) repeated and judged, as a result."""

import contextlib
import json
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, ClassVar

from apesim.archive import Archive, read_digest, write_file
from apesim.engine.machine import Machine
from apesim.quantities import Choice, Fault, InputError, parse_range
from apesim.quantities.settings import dumps
from apesim.results import Result, scalars_of
from apesim.studies.discharge import Discharge, Vessel, discharge
from apesim.studies.execution.calls import arguments_of, call_text, public
from apesim.studies.execution.output import make_folder, publish, write_traces
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.execution.pool import Team, workers_for
from apesim.studies.limit.valve_map import PRESSURES, PULSE, TEMPERATURES, compute_map, faults_of_map
from apesim.studies.paper.claims.area import claims_by_area
from apesim.studies.paper.claims.claim import Claim, Verdict
from apesim.studies.paper.discharge import discharge_tests
from apesim.studies.paper.friction.friction_map import friction_table, map_friction
from apesim.studies.paper.judgement import LONG, all_claims
from apesim.studies.paper.page import write_page
from apesim.studies.paper.subject import differences
from apesim.studies.run.operating_conditions import JOBS, PRESSURE, TEMPERATURE
from apesim.studies.terminal.console import Console, plain
from apesim.valve.bench import run_bench

SCOPES = FULL, CLAIMS = "full", "claims"
"""How much is repeated, see `repeat_paper`."""
SCOPE = Choice(SCOPES, "a call")
SECONDS = {FULL: 30.0, CLAIMS: 15.0}
"""Estimated computing time of each scope [s]."""
NUMBERS = {
    "claims": ("1", "claims of the paper"),
    "reproduced": ("1", "claims that the model reproduces"),
    "contradicted": ("1", "claims that the model contradicts"),
    "wall_time_s": ("s", "computing time of the call"),
}


@dataclass(frozen=True, eq=False, repr=False)
class PaperRepetition(Result):
    """The EPV paper's claims, judged on a machine, and its figures.

    Attributes
    ----------
    claims : tuple of Claim
    different : list of str
        In what the machine's valve differs from the paper's.
    map : Archive
        The valve over pressure and temperature.
    vessel : Vessel
        Vessel of the model's own discharge tests.
    tests : Discharge
        Result of these tests.
    frictions : FrictionMap or None
        What the text says of the motion, over friction and the solenoids' area; None where it was left out.
    """

    title: ClassVar[str] = "the EPV paper (doi 10.1631/jzus.A0820373) repeated"

    model: Machine = field(kw_only=True)
    claims: tuple[Claim, ...] = field(kw_only=True)
    different: list[str] = field(kw_only=True)
    map: Archive = field(kw_only=True)
    vessel: Vessel = field(kw_only=True)
    tests: Discharge = field(kw_only=True)
    frictions: Any = field(kw_only=True)

    def to_dict(self) -> dict[str, Any]:
        """Return the result under the keys of ``apesim paper --json``; NaN where JSON says null.

        Returns
        -------
        dict
            ``claims``, ``different_from_the_papers_valve``, ``faults`` and ``wall_time_s``.

        Examples
        --------
        >>> import apesim
        >>> paper = apesim.repeat_paper(apesim.Machine())  # doctest: +SKIP
        >>> paper.to_dict()["claims"][0]["verdict"]  # doctest: +SKIP
        'reproduced'
        """
        claims = [plain(claim._asdict()) for claim in self.claims]
        return {
            "claims": claims,
            "different_from_the_papers_valve": self.different,
            "faults": list(self.warnings),
            "wall_time_s": self["wall_time"],
        }

    def write(self, folder: str | PathLike[str], *, overwrite: bool = False) -> dict[str, Any]:
        """Write page, figures, claims, machine, the map of the valve and that of friction into a folder.

        Parameters
        ----------
        folder : path
            Made if it does not exist.
        overwrite : bool
            Whether what it holds may be replaced.

        Returns
        -------
        dict
            Where they lie, under the keys of ``apesim paper --json``.

        Raises
        ------
        ArchiveError
            The folder holds something that is not to be replaced.
        InputError
            Only the claims were judged.

        Examples
        --------
        >>> import apesim
        >>> paper = apesim.repeat_paper(apesim.Machine())  # doctest: +SKIP
        >>> paper.write("paper")["page"]  # doctest: +SKIP
        'paper/index.html'
        """
        if self.frictions is None:
            right = f'repeat the paper with scope="{FULL}"'
            raise InputError([Fault("write()", "paper", "there is no map of frictions to write", right)])
        from apesim.studies.paper.figures import captions_of, paper_figures

        make_folder(folder, overwrite)
        folder = Path(folder)
        drawn = paper_figures(self.model, self.map, self.tests, self.frictions, folder)
        publish(self.map, folder / "valve_map.h5", overwrite=True)
        claims = json.dumps(self.to_dict()["claims"], indent=1, ensure_ascii=False)
        write_file(folder / "claims.json", claims + "\n")
        write_file(folder / "machine.toml", dumps(self.model, folder))
        friction_map = folder / "friction_map.csv"
        write_traces(friction_map, *friction_table(self.frictions))
        captions = captions_of(self.vessel, self.frictions)
        return {
            "page": str(write_page(self.claims, captions, self.different, self.frictions, folder)),
            "content_sha256": read_digest(folder / "valve_map.h5"),
            "figures": [str(path) for path in drawn],
            "friction_map": str(friction_map),
        }


@public
def repeat_paper(
    machine: Machine,
    *,
    scope: str = FULL,
    jobs: int | None = 1,
    progress: bool | Callable[[str, int, int], object] = False,
    call: str | None = None,
) -> PaperRepetition:
    """Repeat the EPV paper (doi 10.1631/jzus.A0820373): judge its claims, and compute its figures.

    Parameters
    ----------
    machine : Machine
    scope : {"full", "claims"}
        "claims": each claim is judged at the machine's own solenoid area and friction alone. The claim on the friction
        needs the map over friction and area, and is left out with it.
    jobs : int or None
        Processes; None: as many as the work is worth. A script that asks for more than one does so below
        ``if __name__ == "__main__":``, as each process imports it.
    progress : bool or function
        True: show it on standard error; a function is called with the stage, and what is done and in all.
    call : str, optional
        What the archive notes as its call; made from the arguments if left out.

    Returns
    -------
    PaperRepetition

    Raises
    ------
    InputError
        The machine or the scope is wrong.

    Examples
    --------
    It takes some thirty seconds:

    >>> import apesim
    >>> paper = apesim.repeat_paper(apesim.Machine())  # doctest: +SKIP
    >>> paper["reproduced"], paper.write("paper")["page"]  # doctest: +SKIP
    """
    call = call_text(repeat_paper, locals()) if call is None else call
    arguments, machine = arguments_of("repeat_paper", machine)
    chosen = arguments.quantity("scope", scope, SCOPE)
    arguments.quantity("jobs", jobs, JOBS)
    arguments.refuse()

    # The march of the bench, which the maps need, is compiled before the clock starts.
    call_in_thread(run_bench, machine, PULSE).result()
    start = time.perf_counter()
    with _stages(progress) as report:
        computed = call_in_thread(_computed, machine, call, report, scope=SCOPES[chosen or 0], jobs=jobs).result()
    archive, vessel, tests, frictions, claims = computed

    # The numbers of the result: how the claims came out, and the time that it took.
    verdicts = Counter(claim.verdict for claim in claims)
    values = {
        "claims": len(claims),
        "reproduced": verdicts[Verdict.REPRODUCED],
        "contradicted": verdicts[Verdict.CONTRADICTED],
        "wall_time_s": time.perf_counter() - start,
    }
    return PaperRepetition(
        scalars_of(values, NUMBERS),
        warnings=tuple(faults_of_map(archive)),
        machine=machine.to_toml(),
        model=machine,
        claims=tuple(claims),
        different=differences(machine),
        map=archive,
        vessel=vessel,
        tests=tests,
        frictions=frictions,
    )


def _computed(
    machine: Machine, call: str, report: Callable[[str, int, int], object], *, scope: str, jobs: int | None
) -> tuple:
    """The map of the valve, vessel and tests of the solenoid, the map of friction or None, and the claims."""
    grid = parse_range(PRESSURES, PRESSURE, machine.ambient.pressure), parse_range(TEMPERATURES, TEMPERATURE)
    with Team(workers_for(SECONDS[scope], jobs)) as team:
        archive = compute_map(machine, *grid, PULSE, call, partial(report, "pressure and temperature"))
        vessel, records = discharge_tests(machine)
        judges = [(judge, machine) for judge in LONG]
        tests, *claims = team.map(_called, [(discharge, vessel, records), *judges])
        judged = {judge.__name__: claim for judge, claim in zip(LONG, claims, strict=True)}
        if scope == CLAIMS:
            return archive, vessel, tests, None, all_claims(machine, archive, tests, {}, None, judged)
        by_area = claims_by_area(machine, *grid, report=partial(report, "areas of the solenoids"), team=team)
        frictions = map_friction(machine, report=partial(report, "frictions"), team=team)
    return archive, vessel, tests, frictions, all_claims(machine, archive, tests, by_area, frictions, judged)


def _called(function: Callable[..., Any], *arguments: Any) -> Any:
    """Result of a function for its arguments."""
    return function(*arguments)


@contextlib.contextmanager
def _stages(progress: bool | Callable[[str, int, int], object]) -> Iterator[Callable[[str, int, int], object]]:
    """Show progress in stages as it was asked for; yields ``report(stage, done, total)``."""
    if callable(progress):
        yield progress
        return
    with Console(quiet=not progress).stages("paper") as report:
        yield report
