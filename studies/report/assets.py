"""Assets of pages: style, scripts and templates, as they lie in the folder ``assets`` beside this file."""

from functools import lru_cache
from importlib.resources import files


@lru_cache
def read_asset(name: str) -> str:
    """Read an asset by the name of its file, e.g. "style.css", as text.

    >>> read_asset("LICENSE-uplot").splitlines()[0]
    'The MIT License (MIT)'
    """
    return files(__package__).joinpath("assets", name).read_text(encoding="utf-8")
