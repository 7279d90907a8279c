"""Numbers that the text of the documentation quotes: how they are computed, kept and compared.

`compute` of `docs/results/NAME.py` computes them; `docs/results/NAME.json` holds what it gave, when, and by
which commit. A build with `--fresh` computes short results anew, shows what they give, and tells what moved by more
than its stated error. Long ones (`LONG = True`) are computed by `python -m docs.results NAME` alone. Before a release
`python -m docs.results --again` compares both. What takes hours is a record (`RECORD = True`, in place of `LONG`),
which is not computed again. Live ones (`LIVE = True`) take no time: they are computed whenever they are quoted, and
have no JSON.
"""

import ast
import datetime
import importlib
import importlib.metadata
import importlib.util
import json
import math
import platform
import re
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.folders import find_commit

HERE = Path(__file__).parent
PYTHON = ".".join(platform.python_version_tuple()[:2])
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")
_NOT_COMPARED = re.compile(r"[-+]?\d+(?:\.\d+)?e[-+]\d+|[\u2500-\u257f]")


@dataclass(frozen=True)
class Number:
    """A computed number, its unit, and by how much it may move before the text has to be read again.

    The error decides the digits that are printed; 0 is for counts, which may not move.
    """

    value: float
    unit: str = ""
    error: float = 0.0

    @property
    def digits(self) -> str:
        """The value as text, rounded to the error's digit."""
        if self.error == 0.0:
            return f"{self.value:g}"
        decimals = max(0, math.ceil(-math.log10(2.0 * self.error) - 1e-9))
        text = f"{self.value:.{decimals}f}"
        return text.removeprefix("-") if float(text) == 0.0 else text

    @property
    def text(self) -> str:
        """The value with its unit; no line ends between both."""
        space = {"": "", "°": "", "%": "\u202f"}.get(self.unit, "\u00a0")
        return self.digits + space + self.unit


@dataclass(frozen=True)
class Table:
    """A table for the text: heads, with units, and rows of texts and numbers."""

    columns: list[str]
    rows: list[list[str | Number]]


@dataclass(frozen=True)
class Text:
    """What the program printed: a block of lines.

    The numbers in it may move by the relative error; its words may not. Spaces, lines that are drawn, and numbers with
    an exponent, which are errors of rounding, are not compared.
    """

    text: str
    error: float = 1e-3


Value = Number | Table | Text


@dataclass(frozen=True)
class Result:
    """What one file of results gave: named numbers, tables and texts, when, and by which commit."""

    name: str
    what: str
    made: str
    seconds: float
    python: str
    versions: dict[str, str]
    processor: str
    commit: str
    values: dict[str, Value] = field(default_factory=dict)


def names() -> list[str]:
    """The names of all files of results."""
    return sorted(file.stem for file in HERE.glob("*.py") if not file.stem.startswith("_"))


def is_long(name: str) -> bool:
    """Whether the numbers of a file take too long to be computed whenever the site is built (``LONG = True``)."""
    return _flag(name, "LONG")


def is_live(name: str) -> bool:
    """Whether the numbers of a file take no time, so that they are computed whenever they are quoted, and not kept."""
    return _flag(name, "LIVE")


def is_record(name: str) -> bool:
    """Whether the numbers of a file tell of the commit that they were made with, and of no later one."""
    return _flag(name, "RECORD")


def _flag(name: str, key: str) -> bool:
    tree = ast.parse((HERE / f"{name}.py").read_text())
    found = [n.value for n in tree.body if isinstance(n, ast.Assign) and getattr(n.targets[0], "id", "") == key]
    return bool(found and ast.literal_eval(found[0]))


def compute(name: str) -> Result:
    """Compute the numbers of one file, in this process."""
    module = importlib.import_module(f"docs.results.{name}")
    started = time.perf_counter()
    values = module.compute()
    seconds = time.perf_counter() - started
    return Result(
        name=name,
        what=module.__doc__.strip().split("\n")[0],
        made=datetime.date.today().isoformat(),
        seconds=float(f"{seconds:.2g}"),
        python=PYTHON,
        versions={key: importlib.metadata.version(key) for key in ("apesim", "numba", "numpy", "scipy")},
        processor=_processor(),
        commit=find_commit(),
        values=values,
    )


def save(result: Result) -> Path:
    """Write a result beside the file that computed it."""
    content = dict(vars(result))
    content["values"] = {key: _plain(value) for key, value in result.values.items()}
    path = HERE / f"{result.name}.json"
    path.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n")
    return path


def load(name: str) -> Result:
    """What a file of results gave when it was computed last; live ones are computed now."""
    if is_live(name):
        return compute(name)
    content = json.loads((HERE / f"{name}.json").read_text())
    content["values"] = {key: _read(value) for key, value in content["values"].items()}
    return Result(**content)


def find_moves(old: Result, new: Result) -> Iterator[str]:
    """What moved by more than its stated error, appeared or went, one line each."""
    for key in sorted({*old.values, *new.values}):
        before, after = old.values.get(key), new.values.get(key)
        where = f"{old.name}.{key}"
        if before is None or after is None:
            yield f"{where}: {'new' if before is None else 'gone'}"
        elif isinstance(before, Number) and isinstance(after, Number):
            yield from _find_move(where, before, after)
        elif isinstance(before, Table) and isinstance(after, Table):
            if before.columns != after.columns or len(before.rows) != len(after.rows):
                yield f"{where}: another table"
                continue
            for i, (left, right) in enumerate(zip(before.rows, after.rows, strict=True)):
                for head, a, b in zip(before.columns, left, right, strict=True):
                    cell = f"{where}, row {i + 1}, {head}"
                    if isinstance(a, Number) and isinstance(b, Number):
                        yield from _find_move(cell, a, b)
                    elif a != b:
                        yield f"{cell}: {a!r} became {b!r}"
        elif isinstance(before, Text) and isinstance(after, Text):
            yield from _find_other_words(where, before, after)
        else:
            yield f"{where}: a {type(before).__name__} became a {type(after).__name__}"


def _find_move(where: str, before: Number, after: Number) -> Iterator[str]:
    if before.unit != after.unit or not abs(after.value - before.value) <= before.error:
        yield f"{where}: {before.value:g} {before.unit} became {after.value:g} {after.unit} (error {before.error:g})"


def _find_other_words(where: str, before: Text, after: Text) -> Iterator[str]:
    old, new = (_NOT_COMPARED.sub("", text.text) for text in (before, after))
    words = [_NUMBER.sub("#", text).split() for text in (old, new)]
    if words[0] != words[1]:
        first = next((pair for pair in zip(*words, strict=False) if pair[0] != pair[1]), ("an end", "another end"))
        yield f"{where}: other words, {first[0]!r} became {first[1]!r}"
        return
    for a, b in zip(_NUMBER.findall(old), _NUMBER.findall(new), strict=True):
        last_digit = 10.0 ** -len(a.partition(".")[2])
        if abs(float(b) - float(a)) > before.error * abs(float(a)) + 1.01 * last_digit:
            yield f"{where}: {a} became {b} (relative error {before.error:g})"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.processor())


def _plain(value: Value) -> dict[str, Any]:
    if isinstance(value, Text):
        return {"text": value.text.split("\n"), "error": value.error}
    if isinstance(value, Number):
        return {"value": float(value.value), "unit": value.unit, "error": value.error}
    rows = [[_plain(cell) if isinstance(cell, Number) else cell for cell in row] for row in value.rows]
    return {"columns": value.columns, "rows": rows}


def _read(value: dict[str, Any]) -> Value:
    if "text" in value:
        return Text("\n".join(value["text"]), value["error"])
    if "columns" not in value:
        return Number(**value)
    rows = [[Number(**cell) if isinstance(cell, dict) else cell for cell in row] for row in value["rows"]]
    return Table(value["columns"], rows)
