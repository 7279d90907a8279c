"""Processes that tests start."""

import os
import subprocess
import sys

from tests.folders import ROOT


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
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(
        [sys.executable, "-c", script], cwd=folder, env=environment, stdout=subprocess.PIPE, text=True
    )
