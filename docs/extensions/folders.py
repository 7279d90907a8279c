"""The folders of the four layers, each with the first sentence of its docstring."""

import ast
from pathlib import Path

from docs.extensions.markdown import escape

ROOT = Path(__file__).parent.parent.parent
LAYERS = {"apesim": "The ground", "valve": "The valve", "engine": "The engine", "studies": "The studies"}


def write_folders() -> str:
    """A table for each layer: its folders and single files, in the order of their names."""
    parts = []
    for layer, title in LAYERS.items():
        rows = ["| in `" + layer + "/` | holds |", "|---|---|"]
        for path in sorted((ROOT / layer).iterdir()):
            if path.is_dir() and (path / "__init__.py").exists():
                rows += _rows(path, layer)
            elif path.suffix == ".py" and path.stem not in ("__init__", "__main__"):
                rows.append(f"| `{path.name}` | {_first_sentence(path)} |")
        parts.append(f"### {title}: `{layer}/`\n\n" + "\n".join(rows))
    return "\n\n".join(parts) + "\n"


def _rows(folder: Path, layer: str) -> list[str]:
    """A row for a folder, and for each folder within it."""
    inner = sorted(path.parent for path in folder.rglob("__init__.py"))
    return [
        f"| `{path.relative_to(ROOT / layer).as_posix()}/` | {_first_sentence(path / '__init__.py')} |"
        for path in inner
    ]


def _first_sentence(path: Path) -> str:
    """The first paragraph of a module's docstring."""
    text = ast.get_docstring(ast.parse(path.read_text())) or ""
    return escape(text.partition("\n\n")[0].replace("``", ""))
