"""Sealed cases and the blind benchmark.

``python -m tests.truth challenge --seed N --out DIR`` makes a sealed case, ``python -m tests.truth benchmark --cases N
--out DIR`` makes many, has ``apesim gap explain`` and the baselines solve them, and scores all. ``python -m tests.truth
active --first N --cases N --out DIR`` counts the added runs that lead from a refusal or a tie to a name. ``python -m
tests.truth calibrate --first N --cases N --out DIR --to FILE`` fits the probabilities of statements to sealed cases
that no benchmark scores, and judges them. ``python -m tests.truth widen --first N --cases N --out DIR`` counts how many
intervals of strengths hold the truth in solved cases, and by which factor they would hold 95 % of it. ``python -m
tests.truth again --cases N --out DIR`` measures rigs of solved cases that got a name once more, and lets the machines
that were written explain the fresh data. ``python -m tests.truth wrong-numbers --cases N --out DIR`` lets machine files
with one wrong number explain data of the rig.
"""

import argparse
import os
import sys
from pathlib import Path

from tests.campaigns import wrong_numbers
from tests.campaigns.campaign import run_campaign, start_clock
from tests.campaigns.record import add_round, find_next_seed
from tests.folders import find_commit

from .scoring import widening
from .scoring.active import run_loops, seeds_from, table
from .scoring.again import HEADS, repeat_named, rows_again
from .scoring.benchmark import TOOLS, benchmark, read
from .scoring.reliability import calibrate, write
from .scoring.tables import comparison, markdown
from .sealed.bank import Bank
from .sealed.challenge import make
from .sealed.schedule import NONE, plan_of


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.truth")
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser("challenge", help="make a sealed case")
    one.add_argument("--seed", type=int, required=True)
    one.add_argument("--out", required=True, help="folder; gets case/ and answer.json")
    one.add_argument("--bank", help="folder that keeps runs of the default engine for other cases")
    many = commands.add_parser("benchmark", help="make cases, have them solved, and score the verdicts")
    many.add_argument("--cases", type=int, required=True)
    many.add_argument("--first", type=int, default=46000, help="first seed; development used those below 46000")
    many.add_argument(
        "--nones", type=int, default=0, help="further seeds, of which cases with nothing hidden are taken"
    )
    many.add_argument("--out", required=True, help="folder; what is there already is kept")
    many.add_argument("--jobs", type=int, default=1, help="cases at a time")
    many.add_argument("--tools", nargs="+", choices=TOOLS, default=list(TOOLS), help="who solves them; all if left out")
    loop = commands.add_parser("active", help="add runs to open cases, as the program asks and at random, until named")
    loop.add_argument("--first", type=int, default=70000, help="first seed; development's are 70000 to 79999")
    loop.add_argument("--cases", type=int, required=True, help="cases that are likely to be open")
    loop.add_argument("--out", required=True, help="folder; what is there already is kept")
    counted = commands.add_parser("calibrate", help="fit the probabilities of statements to sealed cases")
    counted.add_argument(
        "--first", type=int, default=190000, help="first seed; no benchmark scores those from 190000 on"
    )
    counted.add_argument("--cases", type=int, required=True)
    counted.add_argument("--out", required=True, help="folder of the cases; what is there already is kept")
    counted.add_argument("--jobs", type=int, default=1, help="cases at a time")
    counted.add_argument("--solved", action="store_true", help="count the cases that are solved, and make no others")
    counted.add_argument("--to", required=True, help="file that gets the coefficients: reliability.json")
    widened = commands.add_parser("widen", help="find the factor by which intervals of strengths are too narrow")
    widened.add_argument("--first", type=int, default=190000, help="first seed; those that are not solved are left out")
    widened.add_argument("--cases", type=int, required=True)
    widened.add_argument("--out", required=True, help="folder of solved cases, as `calibrate` and `benchmark` leave it")
    again = commands.add_parser("again", help="let child machines explain fresh data of their rigs")
    again.add_argument("--cases", type=int, required=True, help="the first so many that got a name")
    again.add_argument("--out", required=True, help="folder of solved cases; what is there already is kept")
    wrong = commands.add_parser("wrong-numbers", help="let machine files with one wrong number explain data")
    wrong.add_argument("--cases", type=int, required=True)
    wrong.add_argument(
        "--first", type=int, help=f"first seed; development's are those below {wrong_numbers.FIRST} (default: the next)"
    )
    wrong.add_argument("--out", required=True, help="folder; what is there already is kept")
    wrong.add_argument("--save", action="store_true", help="add the round to the record")
    given = parser.parse_args()
    if given.command == "challenge":
        make(given.seed, given.out, given.bank and Bank(given.bank))
    elif given.command == "active":
        print(table([courses for _, courses in run_loops(seeds_from(given.first, given.cases), given.out) if courses]))
    elif given.command == "calibrate":
        seeds = range(given.first, given.first + given.cases)
        if not given.solved:
            benchmark(seeds, given.out, {"apesim": TOOLS["apesim"]}, given.jobs)
        cases, missing = read(seeds, given.out, "apesim")
        print(f"{len(cases)} cases; {len(missing)} seeds without a verdict", file=sys.stderr)
        if not cases:
            parser.error("none of these cases is solved")
        told, judged = calibrate(cases)
        write(told, given.to)
        print(judged)
    elif given.command == "widen":
        solved, _ = read(range(given.first, given.first + given.cases), given.out, "apesim")
        print(markdown(widening.HEADS, widening.list_rows(solved)), end="\n\n")
        print(markdown(widening.HEADS_OF_MISSED, widening.list_missed(solved)))
    elif given.command == "again":
        print(markdown(HEADS, rows_again(repeat_named(given.out, given.cases, Bank(Path(given.out) / "bank")))))
    elif given.command == "wrong-numbers":
        following = max(wrong_numbers.FIRST, find_next_seed(wrong_numbers.NAME))
        first = following if given.first is None else given.first
        if given.save and (first < following or find_commit().endswith("-dirty")):
            parser.error("a round that is kept has seeds of its own, and is made by a commit")
        seeds = range(first, first + given.cases)
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # in the process of the trials, as on the command line
        found = run_campaign(wrong_numbers.__name__, seeds, given.out, tell=start_clock())
        print(file=sys.stderr)
        print(markdown(wrong_numbers.HEADS, [wrong_numbers.list_cells(seed, one) for seed, one in found.items()]))
        if given.save:
            add_round(wrong_numbers.NAME, found)
    else:
        tools = {name: TOOLS[name] for name in given.tools}
        end = given.first + given.cases
        nones = [seed for seed in range(end, end + given.nones) if plan_of(seed).kind == NONE]
        print(comparison(benchmark([*range(given.first, end), *nones], given.out, tools, given.jobs)))


if __name__ == "__main__":
    main()
