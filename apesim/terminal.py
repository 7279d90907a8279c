"""Text that comes from files, as a terminal may show it.

A terminal obeys what it is sent: a control character in a stranger's file could clear the screen, or hide a line.
"""


def visible(text, keep=""):
    r"""A text whose characters that do not print stand as escapes, e.g. ``\x1b``.

    Parameters
    ----------
    text : str
    keep : str
        Characters that stay as they are, e.g. line breaks where they are the text's own.

    Returns
    -------
    str
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep else c.encode("unicode_escape").decode() for c in text)
