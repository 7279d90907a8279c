"""The API from the docstrings: compiled laws are documented by the functions that they were compiled from."""

import sys

from sphinx.application import Sphinx


def uncover(_app: Sphinx, *_others: object) -> None:
    """Put the Python functions in the place of Numba's dispatchers, which Sphinx takes for data.

    Nothing is compiled after this: the examples have run, the numbers are computed.
    """
    from numba.core.dispatcher import Dispatcher

    for name, module in list(sys.modules.items()):
        if name.split(".")[0] == "apesim":
            for key, value in list(vars(module).items()):
                if isinstance(value, Dispatcher):
                    setattr(module, key, value.py_func)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register."""
    app.connect("env-before-read-docs", uncover)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
