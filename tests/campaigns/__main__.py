"""``python -m tests.campaigns NAME --trials N --out DIR``; ``--save`` adds the round to the campaign's record."""

import argparse
import sys

from tests.folders import find_commit

from .campaign import run_campaign, start_clock, summarise
from .record import add_round, find_next_seed

NAMES = ("inputs", "archives", "kills", "cluster", "failures", "machines", "agreement", "mutants")


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.campaigns")
    parser.add_argument("name", choices=NAMES)
    parser.add_argument("--trials", type=int, required=True)
    parser.add_argument("--first", type=int, help="seed of the first trial (default: the first of no round yet)")
    parser.add_argument("--out", required=True, help="folder of the outcomes; those that are there are kept")
    parser.add_argument("--save", action="store_true", help="add the round to the record")
    parser.add_argument("--jobs", type=int, default=1, help="trials at a time")
    given = parser.parse_args()
    first = find_next_seed(given.name) if given.first is None else given.first
    if given.save and (first < find_next_seed(given.name) or find_commit().endswith("-dirty")):
        parser.error("a round that is kept has seeds of its own, and is made by a commit")
    seeds = range(first, first + given.trials)
    found = run_campaign(f"tests.campaigns.{given.name}", seeds, given.out, given.jobs, tell=start_clock())
    print(file=sys.stderr)
    for word, number, first, is_broken in summarise(found):
        print(f"{'BROKEN ' if is_broken else ''}{word}: {number}, seeds {', '.join(map(str, first))}")
    for seed, one in found.items():
        if one.is_broken:
            print(f"{seed}: {one.word}: {one.detail}")
    if given.save:
        add_round(given.name, found)
    sys.exit(any(one.is_broken for one in found.values()))


if __name__ == "__main__":
    main()
