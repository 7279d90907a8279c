"""The gallery: order of the examples, and where their data are."""

from pathlib import Path

from sphinx.application import Sphinx

READS_DATA = '"data/'
"""How the path of a file of data begins in an example."""
TITLE = ".. rst-class:: sphx-glr-example-title"
"""What sphinx-gallery writes above the title of an example."""
WHERE_DATA_ARE = """.. note::

    This example reads files of the folder ``data``, which a download does not hold. Run it in the folder
    ``docs/examples`` of the source code, or copy ``docs/examples/data`` beside what you downloaded.

"""

ORDER = [
    "first_run",
    "own_machine",
    "sweep_over_pressure",
    "cam_against_epv",
    "what_limits_30_hz",
    "timing_map_to_header",
    "soft_landing",
    "optimum",
    "real_air",
    "own_valve_from_discharge_test",
    "laboratory_data",
    "missing_effect_found",
    "own_effect",
    "sweep_on_a_cluster",
    "archives_elsewhere",
    "paper_in_one_page",
]


def order(file: str) -> int:
    """The place of an example in the gallery; one that is not named in ORDER is an error."""
    return ORDER.index(Path(file).stem)


def note_data(_app: Sphinx, page: str, source: list[str]) -> None:
    """Say at the top of an example that reads data where they are."""
    if page.startswith("gallery/") and READS_DATA in source[0]:
        above, title, below = source[0].partition(TITLE)
        if not title:
            raise ValueError(f"{page}: sphinx-gallery writes no {TITLE!r} any more")
        source[0] = above + WHERE_DATA_ARE + title + below


def setup(app: Sphinx) -> dict[str, bool]:
    """Register."""
    app.connect("source-read", note_data)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
