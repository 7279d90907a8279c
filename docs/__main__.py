"""Build the documentation: `python -m docs` leaves the site in build/site, and fails on any warning.

`--draft` runs no examples. `--fresh` reads all pages again, and computes the numbers in them that take minutes.
"""

import argparse
import sys
import time
from pathlib import Path

from sphinx.cmd.build import main as build

HERE = Path(__file__).parent


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m docs", description=__doc__.split("\n")[0])
    parser.add_argument("--draft", action="store_true", help="run no examples")
    parser.add_argument("--fresh", action="store_true", help="read all pages and compute short numbers anew")
    parser.add_argument("--out", type=Path, default=HERE.parent / "build" / "site", help="folder of the site")
    options = parser.parse_args()
    arguments = ["-W", "--keep-going", "-n", "-q", "-d", str(options.out.parent / "doctrees")]
    if options.fresh:
        arguments.append("-E")
    if options.draft:
        arguments += ["-D", "plot_gallery=0"]
    elif options.fresh:
        arguments += ["-D", "apesim_fresh_results=1"]
    started = time.perf_counter()
    status = build([*arguments, "-b", "html", str(HERE), str(options.out)])
    took = time.perf_counter() - started
    if status == 0:
        size = sum(file.stat().st_size for file in options.out.rglob("*") if file.is_file())
        print(f"{options.out / 'index.html'}: {size / 1e6:.1f} MB in {took:.0f} s")
    else:
        print(f"failed after {took:.0f} s", file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
