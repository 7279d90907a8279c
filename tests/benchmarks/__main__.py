"""Measure this code beside older releases: ``python -m tests.benchmarks OLD.whl …``, on a machine with no other load.

Each wheel is installed into an environment of its own, beside the packages of this one, with its own folder of caches.
All take turns at each row, and the least time counts, as what disturbs only adds. Nothing fails on a time.
"""

import argparse
import math
import sys
import tempfile
from collections import Counter
from pathlib import Path

from tests.benchmarks.environments import build_wheel, make_environment
from tests.benchmarks.record import FILE, NOW, describe_run, update_record
from tests.benchmarks.rows import FIRST, ROWS, describe, time_of

METHODS = "methods"
"""Name of the table of methods for the bench, the program in C among them."""
MAX_FIRST_RUNS = 2
"""Turns of first runs, which take most of a minute each, and whose processor time hardly varies."""


def main(given=None):
    """Print the table, and keep it where that is wanted."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks", description=__doc__.split("\n")[0])
    parser.add_argument("wheels", nargs="*", type=Path, metavar="OLD.whl", help="older releases, the oldest first")
    parser.add_argument(
        "--new", type=Path, metavar="NEW.whl", help="wheel of this code; built of its commit if left out"
    )
    parser.add_argument("--quick", action="store_true", help="leave out what takes more than 5 s")
    parser.add_argument(
        "--only",
        action="append",
        metavar="NAME",
        help=f"may be repeated; of {', '.join((METHODS, *(r.name for r in ROWS)))}",
    )
    parser.add_argument(
        "--turns", type=int, default=3, help="how often all take turns, of which the first may compile (default: 3)"
    )
    parser.add_argument("--save", action="store_true", help=f"keep it in {FILE.name}, of which the page is made")
    options = parser.parse_args(given)
    unknown = set(options.only or ()) - {METHODS, *(row.name for row in ROWS)}
    if unknown:
        parser.error(f"no row {', '.join(sorted(unknown))}")
    chosen = [row for row in ROWS if (not options.only or row.name in options.only)]
    chosen = [row for row in chosen if not (options.quick and row.is_long)]
    run = describe_run()
    keep = update_record if options.save else lambda lines: None
    if options.save and not (options.only or options.quick):
        FILE.unlink(missing_ok=True)  # all is measured again: no line of another machine stays
    if not options.only or METHODS in options.only:
        keep([line | run for line in _compare_methods(options.turns)])
    if chosen:
        with tempfile.TemporaryDirectory() as folder:
            _compare_releases(chosen, options, Path(folder), lambda lines: keep([line | run for line in lines]))


def _compare_methods(turns):
    """Lines of the methods for the bench."""
    from tests.benchmarks.methods import compare, table

    found = compare(turns)
    print(*table(found), "", sep="\n", flush=True)
    for each in found:
        costs = {"seconds": each.seconds, "evaluations": each.evaluations or "", "contacts_off": each.off}
        yield {"name": each.words, "group": METHODS, "words": each.words, "code": NOW} | costs


def _compare_releases(chosen, options, folder, keep):
    """Measure rows in all releases, print each as soon as it is measured, and keep its lines."""
    wheels = [*options.wheels, options.new or build_wheel(folder / "wheel")]
    labels = [*_labels(options.wheels), NOW]
    releases = [make_environment(*each, folder / f"{i}") for i, each in enumerate(zip(wheels, labels, strict=True))]
    heads = [*labels, *(f"{label} : {NOW}" for label in labels[:-1])]
    group = None
    for row in chosen:
        if row.group != group:
            unit = ", processor time" if row.group == FIRST else ""
            print(f"{row.group + unit:64s}" + "".join(f"{head:>14s}" for head in heads), flush=True)
            group = row.group
        costs = _measure(row, releases, min(options.turns, MAX_FIRST_RUNS) if row.group == FIRST else options.turns)
        times = [time_of(row.group, cost) for cost in costs]
        ratios = [time / times[-1] for time in times[:-1]]
        cells = [*map(describe, times), *("—" if math.isnan(ratio) else f"{ratio:.2f}" for ratio in ratios)]
        print(f"  {row.words:62s}" + "".join(f"{cell:>14s}" for cell in cells), flush=True)
        for label, cost in zip(labels, costs, strict=True):
            if cost.why:
                print(f"    {label}: {cost.why}", file=sys.stderr)
        keep([_line(row, label, cost) for label, cost in zip(labels, costs, strict=True)])


def _measure(row, releases, turns):
    """The least cost in each release, all taking turns; one that lacks the row, or fails, is not asked again."""
    found = [[] for _ in releases]
    for _ in range(turns):
        for costs, release in zip(found, releases, strict=True):
            if not (costs and costs[-1].why):
                costs.append(row.measure(release))
    return [min(costs, key=lambda cost: time_of(row.group, cost)) for costs in found]


def _line(row, label, cost):
    """A line of the record."""
    numbers = {"seconds": cost.seconds, "processor_seconds": cost.processor, "cycles": cost.cycles}
    known = {key: value for key, value in numbers.items() if value is not None and not math.isnan(value)}
    return {"name": row.name, "group": row.group, "words": row.words, "code": label, "why": cost.why} | known


def _labels(wheels):
    """Versions of wheels; where one occurs twice, with the folder that the wheel stands in."""
    versions = [wheel.name.split("-")[1] for wheel in wheels]
    counts = Counter(versions)
    return [
        version if counts[version] == 1 else f"{version} ({wheel.absolute().parent.name})"
        for version, wheel in zip(versions, wheels, strict=True)
    ]


if __name__ == "__main__":
    main()
