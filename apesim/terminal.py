"""Text that comes from files, as a terminal may show it.

A terminal obeys what it is sent: a control character in a stranger's file could clear the screen, or hide a line.
"""


def visible(text: str, keep: str = "") -> str:
    r"""Return a text whose characters that do not print stand as escapes.

    Parameters
    ----------
    text : str
        Text of a stranger.
    keep : str
        Characters that stay as they are, e.g. line breaks where they are the text's own.

    Returns
    -------
    str
        Text that a terminal may be sent.

    Examples
    --------
    >>> print(visible("red: " + chr(27) + "[31m"))
    red: \x1b[31m
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep else c.encode("unicode_escape").decode() for c in text)
