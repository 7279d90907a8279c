"""Machine files with one wrong number, beside data of the independent simulator: whether `gap explain` names it.

A number counts as named where it alone is said to be wrong, where one effect is named with the number beside it, or
where the data are refused as impossible with its key. What is kept of a trial tells the case and what was said.
"""

import time
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from apesim import InputError, Machine
from apesim.engine.effects import ALL_EFFECTS
from apesim.quantities.units import unit
from apesim.studies.estimation.parameters import value_of
from apesim.studies.gap.report.effect_rows import MISSTATING, describe_numbers
from apesim.studies.gap.search.file_numbers import list_misstated
from apesim.studies.gap.workflow import explain
from tests.truth.sealed.library import ENGINE
from tests.truth.sealed.wrong_numbers import BLOCK, OF_VALVE, draw_wrong_number, write_wrong_number

from .campaign import Outcome, trial_folder
from .record import split_word

NAME = "wrong_numbers"
"""Name of the record."""
FIRST = 1000
"""First seed of the record; smaller ones are for development."""
LONGEST = 600.0
"""That a trial may take [s], the warm-up and the laboratory's own runs with it."""
MEMORY = 4_000_000_000
NAMED, REFUSED, IN_A_CLASS, AMONG, WRONG, OPEN, UNSEEN = OUTCOMES = (
    "named",
    "refused with its key",
    "in a class",
    "named beside another",
    "another name",
    "left open",
    "not seen",
)
"""What becomes of a case; the first two count as named."""
HOLDS, MISSES, NO_INTERVAL = "holds it", "misses it", "–"
APART = "; "
HEADS = (
    "seed",
    "wrong number",
    "error",
    "the rest of the rig",
    "sigmas",
    "verdict",
    "said",
    "counted as",
    "95 % interval",
    "processor time [s]",
)


class Told(NamedTuple):
    """What a case was, and what was said of it; as text, the detail of an outcome."""

    error: str
    """Size of the error of the file, as text."""
    rig: str
    sigmas: str
    verdict: str
    said: str
    """Names that were given."""
    interval: str
    """Whether the 95 % interval of the number holds the rig's."""
    seconds: str
    """Processor time [s]."""

    @classmethod
    def read(cls, detail):
        """What a detail tells."""
        return cls(*detail.split(APART))


def list_cells(seed, one):
    """A case as a row below `HEADS`; one without a verdict has the outcome of its process alone."""
    key, outcome = split_word(one.word)
    told = Told.read(one.detail) if outcome in OUTCOMES else Told(*["–"] * len(Told._fields))
    return [str(seed), key, told.error, told.rig, told.sigmas, told.verdict, told.said, outcome, *told[-2:]]


def trial(seed):
    """Let a machine file with a wrong number explain the rig's data.

    Parameters
    ----------
    seed : int

    Returns
    -------
    Outcome
    """
    warm_up(BLOCK[seed % len(BLOCK)].bench)
    case = draw_wrong_number(seed)
    with trial_folder() as folder:
        write_wrong_number(case, folder / "case")
        outcome, told = judge(case, folder / "case")
    return Outcome(f"{case.number.key}: {outcome}", outcome not in (NAMED, REFUSED), APART.join(told))


@lru_cache
def warm_up(bench):
    """Explain a case of a bench, so that all is compiled and loaded as others are timed."""
    with trial_folder() as folder:
        case = draw_wrong_number(len(OF_VALVE) * 2 if bench == ENGINE else 1)
        write_wrong_number(case, folder / "case")
        judge(case, folder / "case")


def judge(case, folder):
    """Have a case explained, and hold what is said against it.

    Parameters
    ----------
    case : tests.truth.sealed.wrong_numbers.WrongNumber
    folder : path
        Its data and its machine file.

    Returns
    -------
    str, Told
        One of `OUTCOMES`, and what led to it.
    """
    machine, key = Machine.load(Path(folder) / "machine.toml"), case.number.key
    begun = time.process_time()
    try:
        explanation, refusal = explain(machine, folder), ""
    except InputError as error:
        explanation, refusal = None, str(error)
    seconds = time.process_time() - begun
    if explanation is None:
        verdict, names, interval = "refused as impossible", [], None
        outcome = REFUSED if key in refusal else WRONG
    else:
        verdict, rows = str(explanation.verdict), explanation.effects
        outcome, names = weigh(key, explanation)
        interval = find_interval(key, rows, machine) if outcome == NAMED else None
    rig = "off" if case.nuisances else "as in the file"
    holds = NO_INTERVAL if interval is None else HOLDS if interval[0] <= case.right <= interval[1] else MISSES
    said = " ".join(names) or "–"
    return outcome, Told(case.error, rig, f"{case.sigmas:.0f}", verdict, said, holds, f"{seconds:.1f}")


def weigh(key, explanation):
    """One of `OUTCOMES` for an explanation, and the names that it gives."""
    verdict, rows = explanation.verdict, explanation.effects
    names = [row["name"] for row in rows]
    if verdict == "NO_GAP":
        return UNSEEN, []
    if verdict in ("REFUSED", "AMBIGUOUS"):
        return OPEN, names
    if verdict == "NAMED_CLASS":
        decision = explanation.decision
        names = [name for choice in (decision.best, *decision.rivals) for name in choice.names]
        return IN_A_CLASS if any(key in find_keys(name) for name in names) else WRONG, names
    # Numbers that are wrong besides an effect are named, too, though an effect is blamed that is not there.
    numbers = describe_numbers(explanation.best) if explanation.best else []
    is_said = any(key in (row["key"], *(each["key"] for each in row["misstated"])) for row in (*rows, *numbers))
    is_alone = len(rows) == 1 and not numbers and verdict in ("CALIBRATION", "NAMED")
    return (NAMED if is_alone else AMONG) if is_said else WRONG, names + [row["name"] for row in numbers]


def find_keys(name):
    """Keys of the numbers that a name stands for: an effect's, or the name itself."""
    return [name, *(number.key for effect in ALL_EFFECTS if effect.name == name for number in effect.search.misstated)]


def find_interval(key, rows, machine):
    """The 95 % interval of a number that is named, in the unit of the machine file; None: there is none.

    Where an effect is named, it is the interval of the effect's strength, as the number that does the same.
    """
    for row in rows:
        if row["interval_95"] is None:
            continue
        if row["key"] == key:
            return tuple(row["interval_95"])
        for number in list_misstated(machine, MISSTATING[row["key"]]) if row["key"] in MISSTATING else ():
            if number.key == key:
                strengths = [end * unit(row["unit"]).si("1") for end in row["interval_95"]]
                ends = sorted(number.correct(value_of(machine, key), strength) for strength in strengths)
                scale = next(each.scale for each in BLOCK if each.key == key)
                return tuple(end / scale for end in ends)
    return None
