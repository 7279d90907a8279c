"""Figures of a study, kept beside the numbers of a long result."""

import tempfile
from collections.abc import Callable
from pathlib import Path

from docs.results import HERE

FOLDER = HERE / "figures"


def keep(draw: Callable[[str], object], **paths: str | Path) -> None:
    """Draw the figures of a study, and keep some of them as PNG.

    Parameters
    ----------
    draw : callable
        Draws all figures into a folder, or into one named figures in it.
    **paths : str or Path
        Where to keep a figure, by its own name: a name in the folder of figures, or a path.
    """
    FOLDER.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        draw(folder)
        for own, path in paths.items():
            [drawn] = Path(folder).rglob(f"{own}.png")
            kept = path if isinstance(path, Path) else FOLDER / f"{path}.png"
            kept.write_bytes(drawn.read_bytes())
