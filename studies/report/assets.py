"""Assets of pages: style, scripts and templates, as they lie in the folder ``assets`` of a package."""

from functools import lru_cache
from importlib.resources import files


@lru_cache
def read_asset(name: str, package: str = __package__) -> str:
    """Read an asset by the name of its file, e.g. "style.css", as text; of a package that has such a folder.

    >>> read_asset("LICENSE-uplot").splitlines()[0]
    'The MIT License (MIT)'
    """
    return files(package).joinpath("assets", name).read_text(encoding="utf-8")
