"""Pages that the program writes itself: commands, machine file, library of effects.

Each function of PAGES returns Markdown. It is written to docs/generated/NAME.md before Sphinx reads, and a page takes
it in by an include.
"""

from collections.abc import Callable
from pathlib import Path

from sphinx.application import Sphinx

HERE = Path(__file__).parent.parent / "generated"


def write_effects() -> str:
    """The library of effects, in the order in which the march meets them."""
    import apesim

    return "\n".join(f"## `{name}`\n" for name in apesim.list_effects())


PAGES: dict[str, Callable[[], str]] = {"effects": write_effects}


def write(_app: Sphinx) -> None:
    """Write what has changed."""
    HERE.mkdir(exist_ok=True)
    for name, function in PAGES.items():
        path, text = HERE / f"{name}.md", function()
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
