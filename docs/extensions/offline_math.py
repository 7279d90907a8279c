"""MathJax from the site itself, so that equations show without a network: one file of the package with that name."""

import importlib.util
import shutil
from pathlib import Path

from sphinx.application import Sphinx

FILE = "tex-svg-full.js"


def copy(app: Sphinx, error: Exception | None) -> None:
    """Copy MathJax with all its extensions and its glyphs into the site."""
    if error is not None or app.builder.format != "html":
        return
    package = importlib.util.find_spec("sphinx-mathjax-offline")
    target = Path(app.outdir) / "_static" / "mathjax" / FILE
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(Path(package.origin).parent / "static" / "mathjax" / FILE, target)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register, and point sphinx.ext.mathjax to the copy."""
    app.config.mathjax_path = f"mathjax/{FILE}"
    app.connect("build-finished", copy)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
