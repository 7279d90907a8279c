"""Simulate air-powered engines whose intake is opened by an electro-pneumatic valve.

The ground that all layers share, in the order in which they build on one another: cache (folders of what is worked out
once), compiling (who is told of it, and how long it took), linking (kernels become machine code with what calls them),
kernel (the compile decorator), stack_array (a few numbers within a kernel), views (parts of an array), packed (tuples
as rows of numbers), linear_table (read between its rows), terminal (text from files as a terminal may show it),
quantities (units, ranges, strict files), flow_function, air (gas, its states), restriction (flow through it), exergy
(of streams and volumes), effect (what an effect is), leak (through a restriction, as an effect), cubic_table (of an
effect's strengths), march (the one adaptive march, and periodic states), reading (what sensors show), late_text
(written when it is read), archive (HDF5), results (named numbers and traces).

The layers above it are `apesim.valve`, `apesim.engine` and `apesim.studies`. In a checkout their folders stand beside
this one; installed, within it.

The names of `__all__` are the public face. They stand in `__init__.pyi`, where editors and type checkers see them, and
are fetched from the layers on first use (SPEC 1), so that importing this package loads none of them.
"""

from pathlib import Path

import lazy_loader

_FOLDER = Path(__file__).parent  # not resolved: an editable install may link each file from elsewhere
if not (_FOLDER / "valve").exists():
    __path__.append(str(_FOLDER.parent))

_fetch, _names, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> object:
    """Fetch a name of the public face, or the version; one that is not there is told with the nearest that is."""
    if name == "__version__":
        from importlib.metadata import version

        return version("apesim")
    try:
        return _fetch(name)
    except AttributeError:
        from difflib import get_close_matches

        near = get_close_matches(name, __all__, n=2)
        right = f"; did you mean {' or '.join(near)}?" if near else ""
        raise AttributeError(f"apesim has no {name}{right}", name=name) from None


def __dir__() -> list[str]:
    """Names of the public face."""
    return [*_names(), "__version__"]
