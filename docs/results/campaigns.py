"""What the campaigns bound: trials, promises broken, and how often a promise may be broken at most."""

from docs.results import Number, Table, Value, load
from docs.results._campaign import as_percentage, bound

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
COLUMNS = ["promise", "campaign", "tried", "broken", "broken less often than"]


def compute() -> dict[str, Value]:
    """The table, of all campaigns that have a record."""
    rows: list[list[str | Number]] = []
    for name, promise in (BY_CHANCE | EACH_ONCE).items():
        try:
            values = load(f"campaign_{name}").values
        except FileNotFoundError:
            rows.append([promise, name, "not yet", "—", "—"])
            continue
        broken, tried = (int(values[key].value) for key in ("broken", "counted"))
        least = as_percentage(bound(broken, tried)).text if name in BY_CHANCE else "each was tried once"
        rows.append([promise, name, Number(tried), Number(broken), least])
    return {"bounds": Table(COLUMNS, rows)}
