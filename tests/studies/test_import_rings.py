"""The rooms of the studies import one another in one direction: none is reached again from what it imports.

Counted is what is imported along with a module; what a function imports as it is called (figures, to draw)
is not.
"""

import ast
from pathlib import Path

from tests.folders import ROOT

STUDIES = ROOT / "studies"
PREFIX = "apesim.studies."


def imported_modules(tree: ast.Module) -> list[str]:
    """Modules that are imported along with one, but for those that only type checkers see."""
    names = []
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.module == "apesim.studies":
            names += [f"{PREFIX}{name.name}" for name in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.append(node.module)
        elif isinstance(node, ast.Import):
            names += [name.name for name in node.names]
    return names


def rooms_of(folder: Path) -> dict[str, set[str]]:
    """Rooms, folders and single files, that each room of a folder imports."""
    rooms: dict[str, set[str]] = {}
    for path in folder.rglob("*.py"):
        room = path.relative_to(folder).parts[0].removesuffix(".py")
        modules = imported_modules(ast.parse(path.read_text(encoding="utf-8")))
        others = {name.removeprefix(PREFIX).split(".")[0] for name in modules if name.startswith(PREFIX)}
        rooms.setdefault(room, set()).update(others - {room})
    return rooms


def ring_in(rooms: dict[str, set[str]]) -> list[str]:
    """One way through rooms that comes back to where it began; [] if there is none."""

    def back_from(way: list[str]) -> list[str]:
        for room in sorted(rooms.get(way[-1], ())):
            if room in way:
                return [*way[way.index(room) :], room]
            if room not in clear and (ring := back_from([*way, room])):
                return ring
        clear.add(way[-1])
        return []

    clear: set[str] = set()
    return next((ring for room in sorted(rooms) if (ring := back_from([room]))), [])


def test_no_room_of_the_studies_is_reached_again_from_what_it_imports():
    rooms = rooms_of(STUDIES)
    assert {"sweep", "timing", "archives", "gap"} <= set(rooms)
    assert " -> ".join(ring_in(rooms)) == ""


def test_a_ring_is_found(tmp_path):
    for name, text in {
        "sweep.py": "from apesim.studies.timing import corrected\n",
        "timing/grid.py": "import numpy\nfrom apesim.studies import valve_map\n",
        "valve_map.py": "from apesim.studies.sweep import STATUS\n",
        "gap.py": "from apesim.studies.sweep import run\n",
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    assert ring_in(rooms_of(tmp_path)) == ["sweep", "timing", "valve_map", "sweep"]
    (tmp_path / "valve_map.py").write_text("def late():\n    from apesim.studies.sweep import STATUS\n")
    assert ring_in(rooms_of(tmp_path)) == []
