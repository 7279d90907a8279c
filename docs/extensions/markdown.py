"""Text of the program as Markdown."""

import re


def escape(text: str) -> str:
    """A text on one line, its special characters as they stand."""
    return re.sub(r"([\\`*_|<>\[\]$])", r"\\\1", " ".join(text.split()))
