"""What the campaigns tried and bound, from the records of their rounds in `tests/campaigns/rounds`."""

from collections import Counter
from math import floor, log10

from docs.results import Number, Table, Value
from tests.campaigns.record import FOLDER, Line, bound, read_record

LIVE = True

BY_CHANCE = {
    "kills": "A sweep that is killed goes on to the same bits.",
    "cluster": "A sweep on a cluster in trouble ends with the same bits.",
    "inputs": "A file that is spoilt is read, or refused with its name.",
    "archives": "A damage to what is read of an archive is seen.",
    "machines": "Balances close and bounds are kept, or one line says why not.",
    "agreement": "An independent simulator gives the same numbers.",
}
"""Promises by the campaign that tries them at random."""
EACH_ONCE = {"failures": "A call of the system that fails costs nothing, or is told and made good."}
"""Promises whose campaign lets each thing happen once, so that no share of all is bounded."""


def compute() -> dict[str, Value]:
    """Bounds of all campaigns; of each, its outcomes by kind, its rounds, and what they add up to."""
    records = {path.stem: read_record(path.stem) for path in sorted(FOLDER.glob("*.csv"))}
    values: dict[str, Value] = {"bounds": _tabulate_bounds(records)}
    for name, lines in records.items():
        values |= {f"{name}.outcomes": _tabulate_outcomes(lines), f"{name}.rounds": _tabulate_rounds(lines)}
        for key in ("count", "tried", "broken"):
            values[f"{name}.{key}"] = Number(sum(getattr(one, key) for one in lines))
    survivors: list[list[str | Number]] = [
        [*one.detail.split(": ", 1)] for one in records["mutants"] if one.outcome == "survives"
    ]
    values["mutants.survivors"] = Table(["number", "mutant"], survivors)
    return values | _find_shares(records)


def _tabulate_bounds(records: dict[str, list[Line]]) -> Table:
    rows: list[list[str | Number]] = []
    for name, promise in (BY_CHANCE | EACH_ONCE).items():
        tried, broken = (sum(getattr(one, key) for one in records[name]) for key in ("tried", "broken"))
        least = as_percentage(bound(broken, tried)).text if name in BY_CHANCE else "each was tried once"
        rows.append([promise, name, Number(tried), Number(broken), least])
    return Table(["promise", "campaign", "tried", "broken", "broken less often than"], rows)


def _tabulate_outcomes(lines: list[Line]) -> Table:
    """How often each outcome was that of each kind: a row a kind."""
    counts: Counter[tuple[str, str]] = Counter()
    for one in lines:
        counts[one.kind, one.outcome] += one.count
    heads = sorted({what for _, what in counts}, key=lambda what: -sum(counts[key] for key in counts if key[1] == what))
    kinds = dict.fromkeys(one.kind for one in lines)
    return Table(["tried", *heads], [[kind, *(Number(counts[kind, what]) for what in heads)] for kind in kinds])


def _tabulate_rounds(lines: list[Line]) -> Table:
    rows: list[list[str | Number]] = []
    for date, commit, first, last in dict.fromkeys(one[:4] for one in lines):
        broken = sum(one.broken for one in lines if (one.first, one.last) == (first, last))
        rows.append([date, f"`{commit}`", f"{first} to {last}", Number(last - first + 1), Number(broken)])
    return Table(["date", "commit", "numbers", "count", "broken"], rows)


def _find_shares(records: dict[str, list[Line]]) -> dict[str, Value]:
    """Shares that the page tells: of machines without a result, and of mutants that were caught."""

    def find_share(lines: list[Line], *kinds: str) -> Number:
        chosen = [one for one in lines if one.kind in kinds or not kinds]
        named = sum(one.count - one.broken for one in chosen if one.outcome != "closes")
        return as_percentage(named / sum(one.count for one in chosen))

    machines, mutants = records["machines"], records["mutants"]
    values: dict[str, Value] = {"machines.named": find_share(machines)}
    for kind in dict.fromkeys(one.kind for one in machines):
        values[f"machines.named.{kind.replace(', ', '_')}"] = find_share(machines, kind)
    noted = sum(one.count for one in records["archives"] if one.outcome == "the root digest is another one")
    caught = sum(one.count for one in mutants if one.outcome.startswith("caught"))
    share = as_percentage(caught / sum(one.count for one in mutants))
    return values | {"archives.noted": Number(noted), "mutants.caught": share}


def as_percentage(share: float) -> Number:
    """A share as a number with two digits."""
    value = 100.0 * share
    return Number(value, "%", 0.05 * 10.0 ** floor(log10(value)) if value else 0.0)
