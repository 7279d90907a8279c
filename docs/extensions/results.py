"""Computed numbers in the text.

Roles `val` and `num` print a number, the directives `result-table` and `result-text` a table, and what was printed.
"""

import sys
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective, SphinxRole

from docs import results
from docs.results import Number, Table, Text, Value

LOADED: dict[str, results.Result] = {}
"""Results of this build, by name."""


class ValueRole(SphinxRole):
    """A computed number, with its unit (`val`) or without (`num`): {val}`file.key`."""

    def __init__(self, *, with_unit: bool) -> None:
        self.with_unit = with_unit

    def run(self) -> tuple[list[nodes.Node], list[nodes.system_message]]:
        value = _find(self, self.text)
        if not isinstance(value, Number):
            message = self.inliner.reporter.error(f"{self.text!r} is no number of docs/results", line=self.lineno)
            return [], [message]
        text = (value.text if self.with_unit else value.digits).replace("-", "\u2212", 1)
        return [nodes.inline(text=text, classes=["computed"])], []


class ResultTable(SphinxDirective):
    """A computed table: `file.key`.

    The option `columns` chooses some of its columns, counted from 1.
    """

    required_arguments = 1
    option_spec: ClassVar[dict[str, Callable[[str], Any]]] = {"columns": directives.positive_int_list}

    def run(self) -> list[nodes.Node]:
        value = _find(self, self.arguments[0])
        if not isinstance(value, Table):
            raise self.error(f"{self.arguments[0]!r} is no table of docs/results")
        chosen = self.options.get("columns", range(1, len(value.columns) + 1))
        columns, *rows = ([cells[i - 1] for i in chosen] for cells in (value.columns, *value.rows))
        value = Table(columns, rows)
        group = nodes.tgroup("", *(nodes.colspec(colwidth=1) for _ in value.columns), cols=len(value.columns))
        group += nodes.thead("", self._row(value.columns))
        group += nodes.tbody("", *(self._row(row) for row in value.rows))
        return [nodes.table("", group, classes=["computed"])]

    def _row(self, cells: Sequence[str | Number]) -> nodes.row:
        row = nodes.row()
        for cell in cells:
            entry = nodes.entry()
            if isinstance(cell, Number):
                entry += nodes.paragraph(text=cell.digits.replace("-", "\u2212", 1), classes=["number"])
            else:
                entry += self.parse_text_to_nodes(cell.replace(" %", "\u202f%"))
            row += entry
        return row


class ResultText(SphinxDirective):
    """What a command printed: `file.key`."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        value = _find(self, self.arguments[0])
        if not isinstance(value, Text):
            raise self.error(f"{self.arguments[0]!r} is no text of docs/results")
        return [nodes.literal_block(value.text, value.text, language="text", classes=["computed"])]


def _find(where: SphinxRole | SphinxDirective, key: str) -> Value | None:
    name, _, rest = key.partition(".")
    if name not in results.names():
        return None
    if results.is_live(name):
        where.env.note_reread()
    else:
        where.env.note_dependency(str(results.HERE / f"{name}.json"))
    if name not in LOADED:
        LOADED[name] = results.load(name)
    return LOADED[name].values.get(rest)


def compute_results(app: Sphinx) -> None:
    """Compute what pages quote as it is now, before the reference takes the compiled functions apart."""
    for name in results.names():
        if results.is_live(name):
            LOADED[name] = results.load(name)
        elif app.config.apesim_fresh_results and not (results.is_long(name) or results.is_record(name)):
            LOADED[name] = results.compute(name)
            for move in results.find_moves(results.load(name), LOADED[name]):
                print(f"{move}; python -m docs.results {name} keeps it", file=sys.stderr)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register roles and directives."""
    app.add_config_value("apesim_fresh_results", False, "", bool)
    app.add_role("val", ValueRole(with_unit=True))
    app.add_role("num", ValueRole(with_unit=False))
    app.add_directive("result-table", ResultTable)
    app.add_directive("result-text", ResultText)
    app.connect("builder-inited", compute_results)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
