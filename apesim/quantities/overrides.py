"""Overrides: an array of tables, each of which gives some keys of a tree another value."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from apesim.quantities.arguments import checked_value
from apesim.quantities.declarations import Declaration
from apesim.quantities.input_errors import MAX_NAMED, InvalidValue, make_fault, quoted
from apesim.quantities.settings import misassigned
from apesim.quantities.trees import Leaf, joined, leaves_of, sections_of, spellings

Overridden = tuple[tuple[str, Any], ...]
"""Type of one table inside: pairs of key and value in SI, in the order of the tree's keys."""


@dataclass(frozen=True)
class Overrides(Declaration):
    """Array of tables, each with keys of a tree that have a value of their own; inside a tuple of `Overridden`.

    `tree` is a parameter class with the sections that can be overridden, `name` the array's in the file, `line` a
    right line of a table in TOML, `max_count` how many tables there are at most, and `source` what they are for.
    """

    tree: Any
    name: str
    line: str
    max_count: int
    source: str
    is_table = True
    is_array = True

    @property
    def entry(self) -> str:  # type: ignore[override]
        """A right line of a table in TOML."""
        return self.line

    @property
    def range_text(self) -> str:
        """The form of the tables."""
        return f"tables [[{self.name}]] in order, at most {self.max_count}, such as {self.entry}"

    @property
    def strong(self) -> str:
        """A right form in TOML."""
        return f"[{{ {self.entry} }}]"

    def read(self, raw: Any, ambient_pressure: float | None = None, folder: Any = None) -> tuple[Overridden, ...]:
        """Return the pairs of key and value of each table of parsed TOML; paths of curves start in `folder`.

        Raises InvalidValue whose ``parts`` have every fault, by number of the table, from 1, and key.

        >>> from typing import Annotated, NamedTuple
        >>> from apesim.quantities import Quantity
        >>> class Valve(NamedTuple):
        ...     stroke: Annotated[float, Quantity("mm", 1, 50, "chosen")] = 9e-3
        >>> class Own(NamedTuple):
        ...     valve: Valve = Valve()
        >>> Overrides(Own, "cylinder", "", 8, "chosen").read([{}, {"valve": {"stroke": "8 mm"}}])
        ((), (('valve.stroke', 0.008),))
        """

        def read_one(each: Any, declaration: Any) -> Any:
            return declaration.read(each, ambient_pressure, folder)

        return self._read_tables(raw, ambient_pressure, read_one)

    def read_given(self, given: Any, ambient_pressure: float | None = None) -> tuple[Overridden, ...]:
        """Return the pairs of key and value of mappings, made in Python, whose values are as `checked_value` has them.

        Raises InvalidValue as `read` does.
        """

        def read_one(each: Any, declaration: Any) -> Any:
            return checked_value(each, declaration, ambient_pressure)

        return self._read_tables(given, ambient_pressure, read_one)

    def _read_tables(
        self, raw: Any, ambient_pressure: float | None, read_one: Callable[[Any, Any], Any]
    ) -> tuple[Overridden, ...]:
        """The pairs of each table, each value by `read_one` of what is given and its declaration."""
        if not isinstance(raw, list | tuple) or not all(isinstance(table, Mapping) for table in raw):
            raise InvalidValue(f"{quoted(raw)} is no list of tables", self.example(raw))
        self._refuse_many(len(raw))
        overrides, parts = [], []
        for number, table in enumerate(raw, 1):
            pairs, faults = self._read_table(table, ambient_pressure, read_one)
            overrides.append(pairs)
            parts += [(joined(f"[{number}]", key), wrong) for key, wrong in faults]
        if parts:
            raise InvalidValue(parts[0][1].wrong, parts[0][1].right, tuple(parts))
        return tuple(overrides)

    def _refuse_many(self, count: int) -> None:
        if count > self.max_count:
            raise InvalidValue(f"{count} tables are too many", f"write at most {self.max_count}")

    def _read_table(
        self, table: Mapping[str, Any], ambient_pressure: float | None, read_one: Callable[[Any, Any], Any]
    ) -> tuple[Overridden, list[tuple[str, InvalidValue]]]:
        """The pairs of one table, and its faults by key."""
        leaves, others = self._leaves, spellings(self.tree)
        found: dict[str, Any] = {}
        faults: list[tuple[str, InvalidValue]] = []
        strange: list[str] = []
        for key, raw in self.flatten(table):
            base = others[key].key if key in others else key
            if base not in leaves:
                strange.append(key)
                continue
            declaration = others[key].declaration if key in others else leaves[key].declaration
            try:
                value = read_one(raw, declaration)
            except InvalidValue as wrong:
                for _, each in wrong.parts or (("", wrong),):
                    fault = make_fault("", key, each, declaration, leaves[base].default, ambient_pressure)
                    faults.append((key, InvalidValue(fault.wrong, fault.right)))
                continue
            if base in found:
                faults.append((key, InvalidValue("is given twice", "give it once")))
            found[base] = others[key].convert(value) if key in others else value
        for key in strange[:MAX_NAMED]:
            fault = misassigned(self.tree, key, "")
            faults.append((key, InvalidValue(fault.wrong, fault.right)))
        if (more := len(strange) - MAX_NAMED) > 0:
            faults.append(("", InvalidValue(f"{more} more unknown keys", f"mend the first {MAX_NAMED} of them")))
        return tuple((key, found[key]) for key in leaves if key in found), faults

    def flatten(self, table: Mapping[str, Any], section: str = "") -> Iterator[tuple[str, Any]]:
        """Flatten a table to keys with dots and what is given for them; `section` is set before the keys."""
        for name, raw in table.items():
            key = joined(section, name)
            if isinstance(raw, Mapping) and key in sections_of(self.tree):
                yield from self.flatten(raw, key)
            else:
                yield key, raw

    def declared(self, key: str) -> Any:
        """Declaration of a key, None where it is unknown."""
        return self._leaves[key].declaration if key in self._leaves else None

    @property
    def _leaves(self) -> dict[str, Leaf]:
        return leaves_of(self.tree)

    def check(self, value: Any) -> None:
        """Refuse pairs of key and value, made in Python, that no table could have given: raises InvalidValue."""
        try:
            tables = [dict(table) for table in value]
        except (TypeError, ValueError):
            raise InvalidValue(f"{quoted(value)} are no pairs of key and value", self._right_in_python) from None
        self._refuse_many(len(tables))
        for number, table in enumerate(tables, 1):
            for key, each in table.items():
                if key not in self._leaves:
                    raise InvalidValue(f"[{number}] has the unknown key {quoted(key)}", self._right_in_python)
                try:
                    self._leaves[key].declaration.check(each)
                except InvalidValue as wrong:
                    raise InvalidValue(f"[{number}].{key}: {wrong.wrong}", wrong.right) from None

    @property
    def _right_in_python(self) -> str:
        key, _, text = self.entry.partition(" = ")
        return f'give a list of mappings, such as [{{}}, {{"{key}": {text}}}]'

    def _converted(self, value: Any) -> tuple[Overridden, ...]:
        """Convert checked pairs to tuples, each value to the type that kernels need, see `Declaration.convert`."""
        leaves = self._leaves
        tables = [dict(table) for table in value]
        return tuple(
            tuple((key, leaf.declaration.convert(table[key])) for key, leaf in leaves.items() if key in table)
            for table in tables
        )

    def render(self, value: Sequence[Overridden], ambient_pressure: float | None = None) -> list[dict[str, Any]] | str:
        """Return the tables that read back as pairs, with texts, bare numbers and curves by key; "" for none.

        Gauge pressures stand above `ambient_pressure` [Pa abs].
        """
        return [{key: self._render_one(key, each, ambient_pressure) for key, each in pairs} for pairs in value] or ""

    def _render_one(self, key: str, value: Any, ambient_pressure: float | None) -> Any:
        declaration = self._leaves[key].declaration
        text = declaration.render(value, ambient_pressure)
        return float(text) if getattr(declaration, "unit", None) == "" and text not in ("", "inf") else text

    def example(self, value: Any, ambient_pressure: float | None = None) -> str:
        """Return a right form for a message; the arguments are unused."""
        return f"write [[{self.name}]] and {self.entry}"
