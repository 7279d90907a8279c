"""What the product imports runs in one direction: no module is reached again from what it imports, and no room is.

A room is a folder or a single file below studies. Read are the imports at the top of a module and those in its
functions, which are made as they are called, and the classes that it names by a text ("module:Class"). Left out is what
type checkers alone see. The public face is no part of a ring: `apesim/__init__` imports none of what it offers.
"""

import ast
import re
from collections.abc import Iterable
from importlib.util import resolve_name
from pathlib import Path

import pytest

from apesim.studies.archives.result_kinds import KINDS
from tests.folders import ROOT
from tests.links import LAYERS

Graph = dict[str, set[str]]
"""Modules, or rooms, that each one imports."""
Edge = tuple[str, str]
"""Module, and one that it imports."""

PREFIX = "apesim.studies."
MACHINE = "apesim.engine.machine"
REGISTRY = "apesim.studies.archives.result_kinds"
ALLOWED: dict[Edge, str] = {
    (MACHINE, "apesim.engine.outside_machine"): (
        "Machine.load() and Machine.with_effects() make machines of classes derived from Machine, each for the effects "
        "from outside that it has, which are tried on the default machine"
    ),
    ("apesim.engine.stated_uncertainties", MACHINE): (
        "[known_to] is a table of the machine, and the keys that it takes are those of the machine"
    ),
    **{
        (REGISTRY, name.split(":")[0]): "an archive is read back as the result that it holds, which is found by a name"
        for name in KINDS.values()
    },
}
"""Imports that close a ring, each with the reason why it stays; none of them is made as its module is loaded."""


class ImportReader(ast.NodeVisitor):
    """Reads what a module of a package imports, wherever in it, into `names`."""

    def __init__(self, package: str) -> None:
        self.package = package
        self.names: set[str] = set()

    def visit_If(self, node: ast.If) -> None:
        is_for_checkers = ast.unparse(node.test) in ("TYPE_CHECKING", "typing.TYPE_CHECKING")
        for each in node.orelse if is_for_checkers else ast.iter_child_nodes(node):
            self.visit(each)

    def visit_Import(self, node: ast.Import) -> None:
        self.names |= {alias.name for alias in node.names}

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        module = resolve_name("." * node.level + (node.module or ""), self.package)
        self.names |= {f"{module}.{alias.name}" for alias in node.names}

    def visit_Constant(self, node: ast.Constant) -> None:
        if isinstance(node.value, str) and re.fullmatch(r"apesim(\.\w+)+:\w+", node.value):
            self.names.add(node.value.split(":")[0])


def enclosing(name: str) -> list[str]:
    """Packages that a module is in, the outermost first."""
    parts = name.split(".")
    return [".".join(parts[:i]) for i in range(1, len(parts))]


def modules_of(root: Path) -> dict[str, Path]:
    """Files of the four packages below a folder, by the names that they are imported by."""
    modules = {}
    for layer in ("apesim", *LAYERS):
        for path in (root / layer).rglob("*.py"):
            name = ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__")
            modules[name if layer == "apesim" else f"apesim.{name}"] = path
    return modules


def imports_of(root: Path) -> Graph:
    """Modules of the four packages that each of them imports; with a module also the packages that it is in."""
    modules = modules_of(root)
    graph: Graph = {}
    for name, path in modules.items():
        reader = ImportReader(name if path.stem == "__init__" else name.rpartition(".")[0])
        reader.visit(ast.parse(path.read_text(encoding="utf-8")))

        # The last part may be a function or a class of a module. What loads a module also loads the packages around it,
        # but those around the importing one are there already.
        found = {full if full in modules else full.rpartition(".")[0] for full in reader.names} & modules.keys()
        around = {package for each in found for package in enclosing(each) if package in modules}
        graph[name] = (found | (around - {*enclosing(name)})) - {name}
    return graph


def without(graph: Graph, edges: Iterable[Edge]) -> Graph:
    """A graph that lacks some imports, and the packages that are loaded with them."""
    left_out = {(name, each) for name, other in edges for each in (other, *enclosing(other))}
    return {name: {other for other in others if (name, other) not in left_out} for name, others in graph.items()}


def rooms_of(graph: Graph) -> Graph:
    """Rooms of the studies that each room imports."""
    rooms: Graph = {}
    for name, others in graph.items():
        if name.startswith(PREFIX):
            room = name.split(".")[2]
            found = {other.split(".")[2] for other in others if other.startswith(PREFIX)}
            rooms.setdefault(room, set()).update(found - {room})
    return rooms


def rings_in(graph: Graph) -> list[str]:
    """Ways that come back to where they began, the shortest first; without the last import of each there is none."""
    rings, clear = [], set()

    def follow(way: list[str]) -> None:
        for name in sorted(graph.get(way[-1], ())):
            if name in way:
                rings.append([*way[way.index(name) :], name])
            elif name not in clear:
                follow([*way, name])
        clear.add(way[-1])

    for name in sorted(graph):
        if name not in clear:
            follow([name])
    return [" -> ".join(ring) for ring in sorted(rings, key=len)]


@pytest.fixture(scope="module")
def product():
    return imports_of(ROOT)


def test_no_module_is_reached_again_from_what_it_imports(product):
    assert {MACHINE, "apesim.valve.bench", "apesim.march.adaptive", "apesim.studies.sweep.study"} <= set(product)
    rings = rings_in(without(product, ALLOWED))
    assert not rings, "\n".join(rings)


@pytest.mark.parametrize("edge", ALLOWED, ids=" -> ".join)
def test_what_is_allowed_closes_a_ring(product, edge):
    assert rings_in(without(product, ALLOWED.keys() - {edge})) != []


def test_no_room_of_the_studies_is_reached_again_from_what_it_imports(product):
    rooms = rooms_of(without(product, ALLOWED))
    assert {"sweep", "timing", "archives", "gap"} <= set(rooms)
    rings = rings_in(rooms)
    assert not rings, "\n".join(rings)


def write_product(root: Path, texts: dict[str, str]) -> Path:
    """Write a product of few files, each by its path below a folder."""
    for path, text in texts.items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text)
    return root


RATES = "import numpy\nfrom apesim.engine import cycle\n"


@pytest.mark.parametrize(
    "cycle, is_ring",
    [
        ("from apesim.engine.rates import power\n", True),
        ("def late():\n    from apesim.engine.rates import power\n", True),
        ("class Cycle:\n    def late(self):\n        import apesim.engine.rates as rates\n", True),
        ("try:\n    from .rates import power\nexcept ImportError:\n    pass\n", True),
        ("if TYPE_CHECKING:\n    pass\nelse:\n    from apesim.engine.rates import power\n", True),
        ("KINDS = {'rates': 'apesim.engine.rates:Rates'}\n", True),
        ("if TYPE_CHECKING:\n    from apesim.engine.rates import power\n", False),
        ("if typing.TYPE_CHECKING:\n    from apesim.engine.rates import power\n", False),
        ("def late():\n    from apesim import run_engine\n", False),  # which the face fetches as it is called
        ("WORDS = 'see apesim.engine.rates: it imports this'\n", False),
    ],
)
def test_a_ring_of_modules_is_found(tmp_path, cycle, is_ring):
    root = write_product(tmp_path, {"apesim/__init__.py": "", "engine/rates.py": RATES, "engine/cycle.py": cycle})
    ring = "apesim.engine.cycle -> apesim.engine.rates -> apesim.engine.cycle"
    assert rings_in(imports_of(root)) == [ring] * is_ring


def test_a_ring_through_what_a_package_loads_is_found(tmp_path):
    texts = {
        "valve/piston.py": "from apesim.engine.effects.blow_by import LEAK\n",
        "engine/effects/__init__.py": "def late():\n    from apesim.valve import piston\n",
        "engine/effects/blow_by.py": "",
    }
    ring = "apesim.engine.effects -> apesim.valve.piston -> apesim.engine.effects"
    assert rings_in(imports_of(write_product(tmp_path, texts))) == [ring]


def test_two_rings_that_share_a_module_are_both_found():
    graph = {"a": {"b", "c"}, "b": {"a"}, "c": {"d"}, "d": {"a"}}
    assert rings_in(graph) == ["a -> b -> a", "a -> c -> d -> a"]
    assert rings_in(without(graph, [("b", "a")])) == ["a -> c -> d -> a"]


def test_a_ring_of_rooms_is_found(tmp_path):
    texts = {
        "studies/sweep.py": "from apesim.studies.timing.solve import corrected\n",
        "studies/timing/solve.py": "",
        "studies/timing/grid.py": "from apesim.studies import valve_map\n",
        "studies/valve_map.py": "def late():\n    from apesim.studies.sweep import STATUS\n",
        "studies/gap.py": "from apesim.studies.sweep import run\n",
    }
    graph = imports_of(write_product(tmp_path, texts))
    assert rings_in(graph) == []
    assert rings_in(rooms_of(graph)) == ["sweep -> timing -> valve_map -> sweep"]
