"""Text of TOML, and what is wrong with one that is none: the line, and the form that would be right."""

import re
import tomllib
from typing import Any

from apesim.quantities.input_errors import Fault, InputError

KEY = r"([A-Za-z0-9_.-]+)"
EXAMPLE = 'write key = "value", a quantity in quotes: '
MAX_SHOWN = 60
"""Letters of a value that a message shows."""
MAX_PARTS = 50
"""Parts of a key with dots; ours have four. The parser's time grows with their square."""
MIN_LONG = 1000
"""Characters of a line from which on its keys are counted; with fewer the parser is quick."""
LONG_KEY = re.compile(rf"""(?<![.\w-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){{{MAX_PARTS}}}""")


def parse_toml(file: str, text: str, example: str) -> dict[str, Any]:
    r"""Parse a text of TOML to nested tables; raises InputError, with the line and the right form, where it is none.

    `example` is a key with a quantity, as it may stand in such a file.
    """
    if any(LONG_KEY.search(line) for line in text.splitlines() if len(line) > MIN_LONG):
        raise InputError([Fault(file, "", f"a key has more than {MAX_PARTS} parts", "write " + example)])
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        what, _, where = str(error).partition(" (at ")
        if what.startswith("Exceeds the limit"):  # of Python, on the digits of an integer
            raise InputError(
                [Fault(file, "", "no TOML: a number has thousands of digits", EXAMPLE + example)]
            ) from None
        where = where.rstrip(")")
        lines = text.splitlines()
        found = re.match(r"line (\d+)", where)
        number = int(found[1]) if found else len(lines)
        explained = _explain(what, lines[:number]) if where and 0 < number <= len(lines) else None
        if explained:
            raise InputError([Fault(file, f"line {number}", *explained)]) from None
        raise InputError([Fault(file, where, f"no TOML: {what}", EXAMPLE + example)]) from None


def _explain(what: str, lines: list[str]) -> tuple[str, str] | None:
    """What is wrong with the last of some lines, and what would be right; None: it is not one of the usual slips."""
    line = lines[-1].strip()
    assigned, declared = re.match(rf"{KEY}\s*=\s*(.*)$", line), re.match(rf"\[+\s*{KEY}", line)
    if assigned and len(line) <= MAX_SHOWN:
        key, value = assigned.groups()
        bare = value.strip("\"'").strip()
        right = f'write {key} = "{bare}"'
        if value[:1] in ('"', "'") and value.count(value[0]) == 1 and _is_open(what):
            return f"{key} has no closing quote", right
        is_open = value[:1] not in ('"', "'", "[", "{") and "#" not in value
        if is_open and bare and ("Expected newline" in what or "Invalid value" in what):
            return f"the value of {key} does not stand in quotes", right
        if what == "Cannot overwrite a value":
            return f"{key} stands twice{_first(lines, key)}", "keep one of them"
    if declared:
        name = declared[1]
        if "twice" in what:
            return f"[{name}] stands twice{_first(lines, '')}", "write all its keys below the first"
        if "Expected ']'" in what:
            return f"[{name} has no closing bracket", f"write [{name}]"
    if "Expected '='" in what and (pair := re.match(rf"{KEY}\s+(\S.*)$", line)) and len(line) <= MAX_SHOWN:
        bare = pair[2].strip("\"'").strip()
        return f"{pair[1]} has no = behind it", f'write {pair[1]} = "{bare}"'
    return None


def _is_open(what: str) -> bool:
    """Whether a text was not closed before its line, or the file, ended."""
    return "Illegal character" in what or "Unterminated string" in what or what.startswith('Expected "\'"')


def _first(lines: list[str], key: str) -> str:
    """First place of a key of the table of the last line, or with "" of the table itself."""
    if not key:
        table = lines[-1].strip()
        number = next((at for at, line in enumerate(lines[:-1], 1) if line.strip() == table), 0)
        return f", first in line {number}" if number else ""
    for at in range(len(lines) - 1, 0, -1):
        before = lines[at - 1].strip()
        if before.startswith("["):
            break
        if re.match(rf"{re.escape(key)}\s*=", before):
            return f", first in line {at}"
    return ""
