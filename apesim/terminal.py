"""Text that comes from files, as a terminal may show it.

A terminal obeys what it is sent: a control character in a stranger's file could clear the screen, or hide a line.
"""


def visible(text: str, keep: str = "") -> str:
    r"""Return a stranger's text whose characters that do not print, but those in `keep`, stand as escapes."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep else c.encode("unicode_escape").decode() for c in text)
