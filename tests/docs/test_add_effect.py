"""What the page on new effects says of the lists that name them all."""

import re
import subprocess

from apesim.engine.effects import ENGINE_EFFECTS
from apesim.valve.effects import VALVE_EFFECTS
from tests.folders import ROOT

READ = ".py", ".md", ".csv", ".toml", ".html", ".rst"


def test_every_list_of_all_effects_is_named_on_the_page_of_how_to_add_one():
    page = (ROOT / "docs" / "developer" / "add_effect.md").read_text(encoding="utf-8")
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    lists = set()
    for path in tracked:
        if path.endswith(READ) and (ROOT / path).exists():
            words = set(re.findall(r"\w+", (ROOT / path).read_text(encoding="utf-8")))
            if any({effect.name for effect in effects} <= words for effects in (VALVE_EFFECTS, ENGINE_EFFECTS)):
                lists.add(path)
    assert len(lists) >= 5
    assert sorted(path for path in lists if path not in page) == []
