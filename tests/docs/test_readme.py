"""The README is short, quotes numbers that are computed, and its Python runs."""

import re

import matplotlib.pyplot as plt

from docs.results import load
from tests.folders import ROOT

TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
INTAKES = {"ideal": "ideal valve", "cam": "cam", "corrected": "EPV, corrected", "fixed": "EPV, fixed"}


def test_readme_is_short():
    assert len(TEXT.encode()) <= 8000


def test_table_is_what_was_computed():
    values = load("intakes").values
    for key, name in INTAKES.items():
        [row] = re.findall(rf"^\| {name}.*$", TEXT, flags=re.MULTILINE)
        torque, air = (values[f"{key}.{what}"] for what in ("brake_torque", "specific_air"))
        assert row.endswith(f"| {torque.digits} {torque.unit} | {air.digits} {air.unit} |")


def test_python_of_the_readme_runs(tmp_path, monkeypatch, capsys):
    [code] = re.findall(r"```python\n(.*?)```", TEXT, flags=re.DOTALL)
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(code, names)
    plt.close("all")
    assert capsys.readouterr().out.strip().endswith("N m")
    assert (tmp_path / "mine.h5").exists()
    assert set(names["table"]["actuation"]) == {"epv", "epv corrected", "ideal"}
    assert "reached" in set(names["timing"].to_pandas()["reason"])
