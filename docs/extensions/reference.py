"""The API from the docstrings: what autodoc and numpydoc need to know of the package.

Compiled laws are documented by the functions that they were compiled from. Classes show no signature, as they are made
by functions. A field of a NamedTuple is described by its declaration, where nothing else describes it. Types are
linked where a page has them.
"""

import inspect
import re
import sys
import typing
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.pycode import ModuleAnalyzer

HERE = Path(__file__).parent.parent / "reference"
FIELD = "Alias for field number"
"""What Python says of a field of a NamedTuple that has no description."""
SHARED = {
    "Result": "apesim.results.Result",
    "Scalar": "apesim.results.Scalar",
    "Trace": "apesim.results.Trace",
    "ArchiveResult": "apesim.studies.archives.archive_result.ArchiveResult",
    "GridResult": "apesim.studies.archives.grid_result.GridResult",
    "Archive": "apesim.archive.records.Archive",
    "Variable": "apesim.archive.records.Variable",
    "MeasuredRun": "apesim.studies.measured.runs.MeasuredRun",
    "EffectEntry": "apesim.studies.gap.search.library.EffectEntry",
    "Effect": "apesim.effect.Effect",
    "Fault": "apesim.quantities.input_errors.Fault",
}
"""Classes that no function of the face returns itself, but that users meet in what is returned."""


def result_classes() -> dict[str, str]:
    """Classes of what the public functions return, by name; each with the name of its page."""
    import apesim

    found = {}
    for name in apesim.__all__:
        function = getattr(apesim, name)
        if inspect.isfunction(function):
            returned = typing.get_type_hints(function)["return"]
            if returned.__module__.startswith("apesim"):
                found[returned.__name__] = f"{returned.__module__}.{returned.__qualname__}"
    return found


def uncover(_app: Sphinx, *_others: object) -> None:
    """Put the Python functions in the place of Numba's dispatchers, which Sphinx takes for data.

    Annotations of parameter classes are reduced to their types; what they declare is kept. Nothing is compiled after
    this: the examples have run, the numbers are computed.
    """
    from numba.core.dispatcher import Dispatcher

    for name, module in list(sys.modules.items()):
        if name.split(".")[0] == "apesim":
            for key, value in list(vars(module).items()):
                if isinstance(value, Dispatcher):
                    setattr(module, key, value.py_func)
                elif inspect.isclass(value) and hasattr(value, "_fields") and value.__module__ == name:
                    _keep_declarations(value)


def _keep_declarations(cls: Any) -> None:
    """Describe the fields of a parameter class, and leave the types alone in its annotations."""
    from apesim.quantities.declarations import Declaration

    texts = dict(getattr(cls, "declared_texts", {}))  # those of its base class, too
    for key, hint in list(cls.__annotations__.items()):
        if typing.get_origin(hint) is typing.Annotated:
            declared = [meta for meta in hint.__metadata__ if isinstance(meta, Declaration)]
            texts[key] = ". ".join([f"{each.range_text}; {each.source}" for each in declared])
            cls.__annotations__[key] = typing.get_args(hint)[0]
        elif key not in texts and hasattr(hint, "_fields"):
            texts[key] = (hint.__doc__ or "").strip().partition("\n")[0]
    cls.declared_texts = texts


def describe_field(_app: Sphinx, what: str, name: str, _item: object, _options: object, lines: list[str]) -> None:
    """Describe a field of a NamedTuple by its declaration."""
    if what not in ("attribute", "property") or not lines or not lines[0].startswith(FIELD):
        return
    path, _, field = name.rpartition(".")
    module, _, cls = path.rpartition(".")
    texts = getattr(getattr(sys.modules.get(module), cls, None), "declared_texts", {})
    lines[:] = [re.sub(r"([\\*`_|])", r"\\\1", texts.get(field, "")), ""]


def describe_once(_app: Sphinx, what: str, name: str, _item: object, _options: object, lines: list[str]) -> None:
    """Say what describes several constants together at the first of them; the others refer to it."""
    if what != "data" or not any(lines):
        return
    module, _, own = name.rpartition(".")
    analyzer = ModuleAnalyzer.for_module(module)
    analyzer.analyze()
    texts = {constant: text for (scope, constant), text in analyzer.attr_docs.items() if not scope}
    alike = [constant for constant, text in texts.items() if text == texts.get(own)]
    first = min(alike, key=analyzer.tagorder.__getitem__, default=own)
    if first != own:
        lines[:] = [f"See :py:data:`~{module}.{first}`.", ""]


def describe_base(_app: Sphinx, what: str, _name: str, item: object, _options: object, lines: list[str]) -> None:
    """Say of a result what it has from its base class, which its own page does not repeat."""
    from apesim.results import Result
    from apesim.studies.archives.archive_result import ArchiveResult

    if what != "class" or not (inspect.isclass(item) and issubclass(item, Result)):
        return
    text = []
    if item is not Result:
        names = "scalars", "traces", "conditions", "warnings", "ending", "converged", "machine"
        text.append(f"It has what every :class:`~apesim.results.Result` has: {_joined(names)}.")
    if issubclass(item, ArchiveResult) and item is not ArchiveResult:
        link = ":class:`~apesim.studies.archives.archive_result.ArchiveResult`"
        text.append(f"It has what every {link} has: {_joined(['archive', 'failed', 'dataset'])}.")
    if text:
        end = next((number for number, line in enumerate(lines) if not line.strip()), len(lines))
        lines[end:end] = ["", *text, ""]


def _joined(names: Sequence[str]) -> str:
    """Names as code, in a list of words."""
    *others, last = (f"``{name}``" for name in names)
    return f"{', '.join(others)} and {last}"


def hide_signature(
    _app: Sphinx, what: str, _name: str, _item: object, _options: object, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """Leave out how a class is made: functions make them."""
    return ("", None) if what in ("class", "exception") else (signature, returned)


def link_classes(app: Sphinx) -> None:
    """Let numpydoc link the classes that have a page, and nothing else."""
    import apesim

    known = {name: f"apesim.{name}" for name in apesim.__all__ if not name.islower()}
    app.config.numpydoc_xref_aliases_complete = SHARED | result_classes() | known


def skip_foreign(_app: Sphinx, what: str, _name: str, item: object, _skip: bool, _options: object) -> bool | None:
    """Leave out what a module only imports, and type variables."""
    if what != "module":
        return None
    is_foreign = not str(getattr(item, "__module__", None) or "apesim").startswith("apesim")
    return True if is_foreign or isinstance(item, typing.TypeVar) else None


def remove_stale_pages(_app: Sphinx) -> None:
    """Remove pages of the reference that were made for a name which is not listed any more."""
    listed = "\n".join(path.read_text() for path in HERE.glob("*.md"))
    names = {name.removeprefix("apesim.") for name in re.findall(r"^   ~?([\w.]+)$", listed, re.MULTILINE)}
    for path in (HERE / "generated").glob("*.rst"):
        if path.stem.removeprefix("apesim.") not in names:
            path.unlink()


def leave_unlinked(_app: Sphinx, _env: object, node: nodes.Element, text: nodes.Node) -> nodes.Node | None:
    """Show a type of a signature, or a name in single backquotes of a docstring, as text where no page has it.

    What of apesim a page refers to by name, as by the role py:func, has to be there.
    """
    if node.get("refdomain") != "py":
        return None
    is_of_signature = "refexplicit" not in node
    is_foreign = not node.get("reftarget", "").startswith("apesim")
    return text if is_of_signature or is_foreign or node.get("reftype") == "obj" else None


def setup(app: Sphinx) -> dict[str, bool]:
    """Register."""
    app.connect("builder-inited", remove_stale_pages, priority=100)
    app.connect("builder-inited", link_classes, priority=900)
    app.connect("autodoc-skip-member", skip_foreign)
    app.connect("env-before-read-docs", uncover)
    app.connect("autodoc-process-docstring", describe_field, priority=400)
    app.connect("autodoc-process-docstring", describe_base, priority=400)
    app.connect("autodoc-process-docstring", describe_once, priority=900)
    app.connect("autodoc-process-signature", hide_signature)
    app.connect("missing-reference", leave_unlinked, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
