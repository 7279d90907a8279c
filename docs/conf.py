"""Sphinx's configuration; `python -m docs` builds the site."""

import importlib.metadata
import os
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy is loaded, as the command line does

project = "apesim"
author = "The apesim authors"
copyright = "2026, the apesim authors"
release = version = importlib.metadata.version("apesim")

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "docs.extensions.gallery",
    "docs.extensions.results",
    "docs.extensions.generated",
    "docs.extensions.offline_math",
    "docs.extensions.reference",
]
exclude_patterns = ["examples", "extensions", "generated", "results", "templates"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 4

autosummary_generate = [f"reference/{path.name}" for path in sorted((HERE / "reference").glob("*.md"))]
autosummary_generate += ["generated/effect_laws.md"]
templates_path = ["templates"]
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
default_role = "py:obj"
maximum_signature_line_length = 88
numpydoc_show_class_members = False
numpydoc_xref_param_type = True
numpydoc_xref_ignore = "all"

sphinx_gallery_conf = {
    "examples_dirs": ["examples"],
    "gallery_dirs": ["gallery"],
    "filename_pattern": r"\.py$",
    "ignore_pattern": r"make_.*\.py$",
    "within_subsection_order": "docs.extensions.gallery.order",
    "reset_modules": ("matplotlib",),
    "remove_config_comments": True,
    # What a call that draws returns says nothing to a reader, and its address changes from build to build.
    "capture_repr": (),
    "show_memory": False,
    "download_all_examples": False,
    "abort_on_example_error": False,
    "image_scrapers": ("matplotlib",),
    "write_computation_times": False,
}

html_theme = "furo"
html_title = f"apesim {release}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {"top_of_page_buttons": []}
pygments_style = "friendly"
pygments_dark_style = "github-dark"
