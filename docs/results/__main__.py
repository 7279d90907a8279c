"""Compute numbers of the documentation anew: `python -m docs.results NAME…`, or `--stale` for all that are stale.

Each file is computed in a process of its own. What moved by more than its stated error is said: the sentences that
quote it have to be read again.
"""

import argparse
import subprocess
import sys

from docs.results import compute, find_moves, find_stale, is_long, is_optional, load, names, save


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m docs.results", description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", help=f"of {', '.join(names())}")
    parser.add_argument("--stale", action="store_true", help="all that are stale, or due and never computed")
    options = parser.parse_args()
    unknown = set(options.names) - set(names())
    if unknown or bool(options.names) == options.stale:
        parser.error(f"no result {', '.join(sorted(unknown))}" if unknown else "names, or --stale")
    chosen = options.names or [name for name in names() if _is_stale(name)]
    if len(chosen) == 1 and not options.stale:
        return _renew(chosen[0])
    return max((subprocess.call([sys.executable, "-m", "docs.results", name]) for name in chosen), default=0)


def _is_stale(name: str) -> bool:
    try:
        return is_long(name) and find_stale(load(name)) is not None
    except FileNotFoundError:
        return not is_optional(name)


def _renew(name: str) -> int:
    try:
        old = load(name)
    except FileNotFoundError:
        old = None
    new = compute(name)
    path = save(new)
    print(f"{path.name}: {len(new.values)} values in {new.seconds:g} s")
    for line in find_moves(old, new) if old else ():
        print("moved: " + line)
    return 0


if __name__ == "__main__":
    sys.exit(main())
