"""Folders that tests read from."""

from pathlib import Path

TESTS = Path(__file__).resolve().parent
ROOT = TESTS.parent
"""The checkout, or the copy of it that the tests of a wheel run in."""
ACCEPTANCE = TESTS / "acceptance"
SAMPLES = TESTS / "samples"
"""Archives of earlier versions, and what sealed cases of the independent simulator are made of."""
