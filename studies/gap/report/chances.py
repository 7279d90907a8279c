"""Probabilities in words, for the page and the terminal."""

from collections.abc import Iterator, Mapping
from typing import Any

FEWEST, MOST = 1, 99
"""Ends of what is said in a hundred: sealed cases do not tell one in a thousand from none."""


def list_chances(data: Mapping[str, Any]) -> list[str]:
    """List how often such statements were right on sealed cases: that of the verdict, and those of single effects.

    `data` is the content of ``verdict.json``; [] where sealed cases tell nothing.

    >>> for sentence in list_chances({"probability": 0.9312, "inclusion": {"side_force": 0.998, "leakage_a": None}}):
    ...     print(sentence)
    Of sealed cases with such a statement, 93 in 100 were right.
    Part of what is missing, by such evidence on sealed cases: side_force in 99 of 100.
    >>> list_chances({"probability": None, "inclusion": {}})
    []
    """
    return [*_write_statement(data["probability"]), *_write_inclusion(data["inclusion"])]


def _write_statement(probability: float | None) -> Iterator[str]:
    if probability is not None:
        yield f"Of sealed cases with such a statement, {_in_hundred(probability)} in 100 were right."


def _write_inclusion(inclusion: Mapping[str, float | None]) -> Iterator[str]:
    known = sorted(((value, name) for name, value in inclusion.items() if value is not None), reverse=True)
    if known:
        first, *others = (f"{name} in {_in_hundred(value)}" for value, name in known)
        listed = ", ".join([f"{first} of 100", *others])
        yield f"Part of what is missing, by such evidence on sealed cases: {listed}."


def _in_hundred(probability: float) -> int:
    return min(max(round(100.0 * probability), FEWEST), MOST)
