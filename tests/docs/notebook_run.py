"""Execute an example as the notebook that its page offers: ``python notebook_run.py SCRIPT REPORT``."""

import json
import sys

import nbclient
import nbformat
from sphinx_gallery.gen_gallery import DEFAULT_GALLERY_CONF
from sphinx_gallery.notebook import jupyter_notebook
from sphinx_gallery.py_source_parser import split_code_and_text_blocks


def main(script: str, report: str) -> None:
    """Convert a script, execute the notebook in its folder, and write how many figures its cells show as JSON."""
    _, blocks = split_code_and_text_blocks(script)
    content = json.dumps(jupyter_notebook(blocks, dict(DEFAULT_GALLERY_CONF), "."))
    notebook = nbformat.reads(content, as_version=4)
    nbclient.NotebookClient(
        notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": "."}}
    ).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    shown = sum("image/png" in output.get("data", {}) for output in outputs)
    with open(report, "w", encoding="utf-8") as file:
        json.dump(shown, file)


if __name__ == "__main__":
    main(*sys.argv[1:])
