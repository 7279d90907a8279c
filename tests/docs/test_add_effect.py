"""What the page on new effects says of the lists that name them all."""

import re
import subprocess

import pytest

from apesim.engine.effects import ENGINE_EFFECTS
from apesim.valve.effects import VALVE_EFFECTS
from tests.folders import ROOT

READ = ".py", ".md", ".csv", ".toml", ".html", ".rst"
FOLDERS = "apesim", "valve", "engine", "studies", "docs"


@pytest.mark.parametrize(("layer", "effects"), [("valve", VALVE_EFFECTS), ("engine", ENGINE_EFFECTS)])
def test_one_list_of_the_program_and_its_documentation_names_all_effects_of_a_layer(layer, effects):
    listed = subprocess.run(["git", "ls-files", *FOLDERS], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    names = {effect.name for effect in effects}
    there = [path for path in listed.split() if path.endswith(READ) and (ROOT / path).exists()]
    lists = [path for path in there if names <= set(re.findall(r"\w+", (ROOT / path).read_text(encoding="utf-8")))]
    assert lists == [f"{layer}/effects/__init__.py"]
    assert lists[0] in (ROOT / "docs" / "developer" / "add_effect.md").read_text(encoding="utf-8")
