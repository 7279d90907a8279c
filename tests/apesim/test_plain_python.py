"""The physics passes its tests with compilation switched off, too: compiled and plain Python are the same code."""

import os
import re
import subprocess
import sys

import pytest

from tests.folders import ROOT
from tests.plain import LONG, QUICK


@pytest.mark.parametrize(("stems", "number"), [(QUICK, 240), (QUICK | LONG, 400)], ids=["quick", "all"])
@pytest.mark.slow
def test_the_marked_tests_pass_as_plain_python(stems, number):
    files = sorted(path for path in (ROOT / "tests").rglob("test_*.py") if path.stem in stems)
    command = [sys.executable, "-m", "pytest", "-q", "-m", "plain", "-n", "0", "-p", "no:cacheprovider", *files]
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-3000:]
    assert int(re.search(r"(\d+) passed", done.stdout)[1]) > number
