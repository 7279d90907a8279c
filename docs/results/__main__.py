"""Compute numbers of the documentation anew: `python -m docs.results NAME…` keeps them, `--again` only compares.

Each file is computed in a process of its own. What moved by more than its stated error is said: the sentences that
quote it have to be read again.
"""

import argparse
import subprocess
import sys

from docs.results import HERE, compute, find_moves, is_live, is_record, load, names, save


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m docs.results", description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", help=f"of {', '.join(names())}")
    parser.add_argument(
        "--again", action="store_true", help="compare and keep nothing; without names: all short and long ones"
    )
    options = parser.parse_args()
    unknown = set(options.names) - set(names())
    if unknown or not (options.names or options.again):
        parser.error(f"no result {', '.join(sorted(unknown))}" if unknown else "names, or --again")
    chosen = options.names or [name for name in names() if not (is_live(name) or is_record(name))]
    if len(chosen) == 1:
        return _compute(chosen[0], keep=not options.again)
    mode = ["--again"] * options.again
    return max(subprocess.call([sys.executable, "-m", "docs.results", name, *mode]) for name in chosen)


def _compute(name: str, *, keep: bool) -> int:
    """Compute a file of results; 1 where it is only compared, and has moved."""
    old = load(name) if (HERE / f"{name}.json").exists() else None
    new = compute(name)
    print(f"{name}: {len(new.values)} values in {new.seconds:g} s", flush=True)
    moves = list(find_moves(old, new)) if old else []
    for line in moves:
        print("moved: " + line, flush=True)
    if keep and not is_live(name):
        save(new)
    return int(bool(moves) and not keep)


if __name__ == "__main__":
    sys.exit(main())
