"""Text of a file in blocks of whole lines, whatever its encoding and however long the file is."""

import codecs
import os
import re
from collections.abc import Iterator
from io import TextIOWrapper
from pathlib import Path
from typing import BinaryIO

from apesim.quantities import InvalidValue, quoted
from apesim.quantities.files import open_regular, require_file

BLOCK_LENGTH = 1 << 22
"""Characters that are read at once: many rows, and little memory beside the numbers."""
HEAD_BYTES = 1 << 18
"""Bytes from which encoding, separator and marks are guessed: thousands of rows."""
MAX_LINE_LENGTH = 1 << 20
"""Longest line: far above any row of an instrument; a longer one is no table."""
WINDOWS = re.compile(rb"[\x80-\x9f]")
"""Bytes that no text in latin-1 has; all but five are characters in cp1252, such as a dash."""
UNDEFINED = re.compile(rb"[\x81\x8d\x8f\x90\x9d]")
"""Bytes that cp1252 does not have."""
MIN_ZEROS = 0.2
"""Share of zero bytes above which a text without a mark of its byte order is UTF-16: half of them are zero there, and
none in other texts."""

MARK, MARKING = "\udc80", "apesim.mark"
"""Character that no text has, and the name of what puts it where bytes are no text of an encoding."""
codecs.register_error(MARKING, lambda error: (MARK, error.end))  # type: ignore[attr-defined]


def open_data(path: Path) -> BinaryIO:
    """Open a regular file for reading; raises InvalidValue where it cannot be read, or is no regular file."""
    require_file(path)
    try:
        return open(path, "rb", opener=open_regular)
    except OSError as error:
        raise InvalidValue(f"{quoted(str(path))} cannot be read: {error.strerror}") from None


def guess_encoding(data: bytes, *, is_whole: bool) -> str:
    """Guess the encoding of a text from its first bytes; `is_whole` tells that they are all of it.

    It is UTF-16 where a mark of the byte order or zero bytes show it, else UTF-8. Where the bytes are no UTF-8 it is
    latin-1, or cp1252 where they have characters of Windows that latin-1 does not have.

    >>> [guess_encoding("Weg [µm]".encode(name), is_whole=True) for name in ("utf-8", "utf-16", "latin-1")]
    ['utf-8', 'utf-16', 'latin-1']
    >>> guess_encoding("Weg – roh [µm]".encode("cp1252"), is_whole=True)
    'cp1252'
    """
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    if data.startswith(codecs.BOM_UTF8):
        return "utf-8-sig"
    if data.count(0) > MIN_ZEROS * len(data):
        return "utf-16-le" if data[1::2].count(0) >= data[::2].count(0) else "utf-16-be"
    try:
        codecs.getincrementaldecoder("utf-8")().decode(data, final=is_whole)
    except UnicodeDecodeError:
        return "cp1252" if WINDOWS.search(data) and not UNDEFINED.search(data) else "latin-1"
    return "utf-8"


def read_head(path: Path) -> tuple[bytes, bool]:
    """Read the first `HEAD_BYTES` of a file, and tell whether they are all; raises InvalidValue where it cannot."""
    with open_data(path) as file:
        data = file.read(HEAD_BYTES)
        return data, os.fstat(file.fileno()).st_size <= len(data)


def blocks_of_lines(path: Path, encoding: str, size: int = BLOCK_LENGTH) -> Iterator[bytes]:
    r"""Give the text of a file, as UTF-8, in blocks of whole lines, each ended by a line feed, whatever stood there.

    `size` is how many characters are read at once. Raises InvalidValue where the file cannot be read, is no such text,
    or has a line that no table has.
    """
    # What is no UTF-8 comes out as the bytes that it is, so that the reader of the cells can name its line.
    is_utf8, lines = encoding in ("utf-8", "utf-8-sig"), 0
    form = ("utf-8-sig", "surrogateescape") if is_utf8 else (encoding, MARKING)
    with open_data(path) as raw, TextIOWrapper(raw, *form, newline=None) as file:
        while True:
            try:
                text = file.read(size)
                text += "" if text.endswith("\n") else file.readline(MAX_LINE_LENGTH)
            except OSError as error:
                raise InvalidValue(f"{quoted(str(path))} cannot be read: {error.strerror}") from None
            except UnicodeError:  # UTF-16 without the mark of its byte order
                text = MARK
            if not text:
                return
            if not is_utf8 and MARK in text:
                lines += text.count("\n", 0, text.index(MARK))
                wrong = f"is no text of the encoding {encoding} after line {lines}"
                raise InvalidValue(wrong, 'write the right encoding = "utf-8" or "latin-1" in [read]')
            lines += text.count("\n")
            if len(text) - text.rfind("\n") > MAX_LINE_LENGTH:
                raise InvalidValue(f"line {lines + 1} is too long for a table", "give a table of text")
            yield (text if text.endswith("\n") else f"{text}\n").encode("utf-8", "surrogateescape")
