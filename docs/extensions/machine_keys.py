"""The keys of a machine file as tables: unit, range, default and source of each, from the declarations."""

from collections.abc import Iterator
from typing import Any

from docs.extensions.markdown import escape

HEAD = "| key | unit | range | default | source of the default |\n|---|---|---|---|---|"


def write_machine() -> str:
    """The default machine as a file, without the folder that it was written in."""
    import apesim

    return apesim.Machine().to_toml()


def write_machine_keys() -> str:
    """A table for each section of the machine; all effects share one."""
    import apesim

    machine = apesim.Machine()
    parts = []
    for path, tree in _sections(machine, ""):
        if path == "effects":
            effects = [(f"{name}.", values) for name, values in zip(tree._fields, tree, strict=True)]
            rows = [row for name, values in effects for row in _rows(values, machine, name)]
        else:
            rows = _rows(tree, machine)
        title = escape((type(tree).__doc__ or "").strip().partition("\n")[0])
        if rows:
            parts.append(f"(section-{path.replace('.', '-')})=\n\n### `[{path}]`\n\n{title}")
            parts.append(":::{div} keys\n\n" + "\n".join([HEAD, *rows]) + "\n\n:::")
    return "\n\n".join(parts) + "\n"


def _sections(tree: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Sections of the machine file with their parameters, in the order of the file; effects are one of them."""
    from apesim.quantities.trees import fields, is_section, joined

    if path:
        yield path, tree
    if path == "effects":
        return
    for key, field in fields(type(tree)).items():
        if is_section(field):
            yield from _sections(getattr(tree, key), joined(path, key))


def _rows(tree: Any, machine: Any, prefix: str = "") -> list[str]:
    """A row for each key of a section."""
    from apesim.quantities.trees import fields, is_section, spellings

    rows = []
    for key, declaration in fields(type(tree)).items():
        if is_section(declaration):
            continue
        text = declaration.render(getattr(tree, key), machine.ambient.pressure)
        default = f"`{text}`" if text else declaration_text(declaration)
        cells = f"`{prefix}{key}`", _unit(declaration), _range(declaration), default, escape(declaration.source)
        rows.append("| " + " | ".join(cells) + " |")
    for key, (_, declaration, _) in spellings(type(tree)).items():
        if "." not in key:
            cells = f"`{prefix}{key}`", _unit(declaration), _range(declaration), "–", escape(declaration.source)
            rows.append("| " + " | ".join(cells) + " |")
    return rows


def declaration_text(declaration: Any) -> str:
    """What holds where an optional key is not given."""
    return f"not given: {escape(declaration.text)}" if getattr(declaration, "text", None) else "not given"


def _unit(declaration: Any) -> str:
    """The unit in which a key is printed; any unit of that kind is read."""
    if hasattr(declaration, "quantity"):
        return f"{declaration.quantity.unit}, a list"
    if not hasattr(declaration, "unit"):
        return "a word" if hasattr(declaration, "options") else "a curve"
    if declaration.suffix:
        return f"{declaration.unit}, gauge or abs"
    return declaration.unit or "–"


def _range(declaration: Any) -> str:
    """The range without its unit, which stands in the column before; that of a pressure says what it is above."""
    text = declaration.range_text
    if hasattr(declaration, "unit"):
        whole = f"{declaration.unit}{declaration.suffix}"
        kept = declaration.suffix.strip()
        return escape(text.replace(f" {whole}", f" {kept}" * bool(kept)) if whole else text)
    return ", ".join(f"`{option}`" for option in getattr(declaration, "options", ())) or escape(text)
