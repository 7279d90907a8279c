"""Files: their text, and the columns of a CSV with units in its header."""

import csv
import re

from apesim.quantities.culprits import Wrong, quoted

MOST_BYTES = 10_000_000


def split_header(text):
    """Name and unit of a column header: "lift [mm]" gives ("lift", "mm"), "lift" gives ("lift", None)."""
    found = re.fullmatch(r"(.*?)\s*\[(.*)\]", text.strip())
    return (found[1], found[2].strip()) if found else (text.strip(), None)


def text_of(path):
    """The text of a UTF-8 file; raises `Wrong` if it cannot be read or is too large."""
    name = quoted(str(path))
    try:
        with open(path, "rb") as file:
            data = file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:  # ValueError: a name that no file can have
        raise Wrong(f"{name} cannot be read: {getattr(error, 'strerror', error)}") from None
    if len(data) > MOST_BYTES:
        raise Wrong(f"{name} is larger than {MOST_BYTES // 10**6} MB")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise Wrong(f"{name} is no text in line {line}", "save it as UTF-8") from None


def csv_columns(path):
    """The columns of a CSV, by (name, unit)."""
    if not path.is_file():  # a pipe or a device might never end
        raise Wrong(f"there is no file {quoted(str(path))}")
    lines = text_of(path).splitlines()
    try:
        headers, *rows = [row for row in csv.reader(lines, strict=True) if row]
        columns = dict(zip(map(split_header, headers), zip(*rows, strict=True), strict=True))
        if len(columns) < len(headers):
            raise ValueError
    except (ValueError, csv.Error):
        form = "differing headers and rows as long as the header"
        raise Wrong(f"{quoted(str(path))} is no CSV with {form}") from None
    return columns
