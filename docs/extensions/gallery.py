"""Order of the examples in the gallery, and words for their pictures."""

import re
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx

ORDER = [
    "first_run",
    "own_machine",
    "own_engine",
    "sweep_over_pressure",
    "cam_against_epv",
    "what_limits_30_hz",
    "timing_map_to_header",
    "governor",
    "closed_loop_timing",
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


THUMBNAIL = re.compile(r"sphx_glr_(\w+)_thumb\.\w+$")
"""Name of the small picture of an example."""


def describe_thumbnails(app: Sphinx, doctree: nodes.document, _page: str) -> None:
    """Give the small picture of each example its title as the text for those who do not see it."""
    for image in doctree.findall(nodes.image):
        named = THUMBNAIL.search(image["uri"])
        title = app.env.titles.get(f"gallery/{named[1]}") if named else None
        if title is not None and not image.get("alt"):
            image["alt"] = f"Figure of the example: {title.astext()}"


def setup(app: Sphinx) -> dict[str, bool]:
    """Register."""
    app.connect("doctree-resolved", describe_thumbnails)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
