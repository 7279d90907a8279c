"""Folders that tests read from, and the commit of the checkout."""

import subprocess
from pathlib import Path

TESTS = Path(__file__).resolve().parent
ROOT = TESTS.parent
"""The checkout, or the copy of it that the tests of a wheel run in."""
ACCEPTANCE = TESTS / "acceptance"
SAMPLES = TESTS / "samples"
"""Archives of earlier versions, and what sealed cases of the independent simulator are made of."""


def find_commit() -> str:
    """The commit of the checkout, with "-dirty" where its files were changed since."""
    command = ["git", "describe", "--always", "--dirty", "--abbrev=7"]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
