"""``python -m tests.campaigns NAME --trials N --out DIR``."""

import argparse
import sys
import time

from .campaign import run_campaign, summarise

NAMES = ("inputs", "archives", "kills", "cluster", "failures", "machines", "agreement", "mutants")


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.campaigns")
    parser.add_argument("name", choices=NAMES)
    parser.add_argument("--trials", type=int, required=True)
    parser.add_argument("--first", type=int, default=0, help="seed of the first trial")
    parser.add_argument("--out", required=True, help="folder of the outcomes; those that are there are kept")
    parser.add_argument("--jobs", type=int, default=1, help="trials at a time")
    given = parser.parse_args()
    start = time.monotonic()

    def tell(done, number):
        left = (time.monotonic() - start) / done * (number - done)
        print(f"\r{done} of {number}, some {left / 60.0:.0f} min left ", end="", file=sys.stderr, flush=True)

    seeds = range(given.first, given.first + given.trials)
    found = run_campaign(f"tests.campaigns.{given.name}", seeds, given.out, given.jobs, tell=tell)
    print(file=sys.stderr)
    for word, number, first, is_broken in summarise(found):
        print(f"{'BROKEN ' if is_broken else ''}{word}: {number}, seeds {', '.join(map(str, first))}")
    for seed, one in found.items():
        if one.is_broken:
            print(f"{seed}: {one.word}: {one.detail}")
    sys.exit(any(one.is_broken for one in found.values()))


if __name__ == "__main__":
    main()
