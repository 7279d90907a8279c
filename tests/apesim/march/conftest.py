"""The march of the small machines of these tests as plain Python: to compile it takes a hundred times as long.

Both are the same code, and give the same bits. What is about compiled code has the mark `compiled`.
"""

import numba
import pytest

from apesim.march import adaptive, periodic


@pytest.fixture(autouse=True)
def plain_march(request, monkeypatch):
    """The march without compiling, wherever a test finds it."""
    if numba.config.DISABLE_JIT or request.node.get_closest_marker("compiled"):
        return
    compiled = adaptive.march
    for module in (adaptive, periodic, request.module):
        if getattr(module, "march", None) is compiled:
            monkeypatch.setattr(module, "march", compiled.py_func)
