"""Processes that tests start."""

import os
import re
import subprocess
import sys

from tests.folders import ROOT

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
"""Environment in which the project is found from any folder."""


def start_python(script, folder):
    """Start Python in a folder; what the script prints can be read.

    Parameters
    ----------
    script : str
    folder : path

    Returns
    -------
    subprocess.Popen
    """
    return subprocess.Popen(
        [sys.executable, "-c", script], cwd=folder, env=ENVIRONMENT, stdout=subprocess.PIPE, text=True
    )


def without_stages(text):
    """What a command said on standard error, but for how long the stages of its work took."""
    return re.sub(r"^[a-z ]+: [\d.]+ s\n", "", text, flags=re.MULTILINE)
