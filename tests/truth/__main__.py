"""``python -m tests.truth challenge --seed N --out DIR``: make a sealed case."""

import argparse

from .challenge import make


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.truth")
    commands = parser.add_subparsers(dest="command", required=True)
    challenge = commands.add_parser("challenge", help="make a sealed case")
    challenge.add_argument("--seed", type=int, required=True)
    challenge.add_argument("--out", required=True, help="folder; gets case/ and answer.json")
    given = parser.parse_args()
    make(given.seed, given.out)


if __name__ == "__main__":
    main()
