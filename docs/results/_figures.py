"""Figures of a study, kept beside the numbers of a long result."""

import tempfile
from pathlib import Path

from docs.results import HERE

FOLDER = HERE / "figures"


def keep(result, **names: str) -> None:
    """Draw the figures of a study, and keep some of them as PNG.

    Parameters
    ----------
    result : GridResult
        Result that draws its figures.
    **names : str
        Name to keep by the figure's own name.
    """
    FOLDER.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        result.draw(folder)
        for own, name in names.items():
            (FOLDER / f"{name}.png").write_bytes((Path(folder) / f"{own}.png").read_bytes())
