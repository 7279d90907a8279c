"""The short machine file: the keys to fill in first."""

import tomllib

from apesim.engine.first_keys import FIRST_KEYS
from apesim.engine.machine import Machine
from apesim.quantities.settings import schema


def keys_of(table, section=""):
    for key, value in table.items():
        yield from keys_of(value, f"{section}{key}.") if isinstance(value, dict) else [section + key]


def test_fifteen_keys_of_the_machine_come_first():
    assert len(FIRST_KEYS) == 15
    assert set(FIRST_KEYS) <= {leaf.key for leaf in schema(Machine)}


def test_the_short_file_of_the_default_machine_holds_them_alone_and_reads_back(tmp_path):
    text = Machine().to_toml("first")
    assert sorted(keys_of(tomllib.loads(text))) == sorted(FIRST_KEYS)
    path = tmp_path / "short.toml"
    path.write_text(text)
    assert Machine.load(path).to_toml() == Machine().to_toml()


def test_the_short_file_of_another_machine_holds_what_is_not_the_defaults_too(tmp_path):
    machine = Machine().with_(
        engine_intake="cam",
        effects_ring_leakage_area="0.1 mm^2",
        groove_area_curve=[[0.0, 0.0], [9e-3, 1e-4]],
        known_to={"valve.stroke": "1 %"},
    )
    text = machine.to_toml("first")
    assert "rod_length" in text and "viscous_friction" not in text
    path = tmp_path / "short.toml"
    path.write_text(text)
    assert Machine.load(path).to_toml() == machine.to_toml()
