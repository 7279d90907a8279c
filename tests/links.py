"""Lay links to the checkout as the packages are installed, for programs that read files and import nothing.

The folders of the layers stand at the top level here and are installed within apesim; mypy takes what it cannot find
for a library without types, and then checks nothing of it. Run as ``python -m tests.links FOLDER``.
"""

import shutil
import sys
from pathlib import Path

from tests.folders import ROOT

LAYERS = "valve", "engine", "studies"


def make_links(folder):
    """Make a folder that holds the one package as it is installed.

    Parameters
    ----------
    folder : pathlib.Path
        What it held of an ``apesim`` is replaced.

    Returns
    -------
    pathlib.Path
        `folder`, to be put on a search path.
    """
    package = folder / "apesim"
    shutil.rmtree(package, ignore_errors=True)
    package.mkdir(parents=True)
    for path in (*(ROOT / "apesim").iterdir(), *(ROOT / layer for layer in LAYERS)):
        if path.name != "__pycache__":
            (package / path.name).symlink_to(path)
    return folder


if __name__ == "__main__":
    make_links(Path(sys.argv[1]))
