"""What pint once said is kept, as long as it can be trusted."""

import json
import math
from fractions import Fraction

import pytest

from apesim.quantities import Wrong, names

ASKED = names._asked
REVOLUTION = Fraction(2.0 * math.pi), (("radian", 1),)


@pytest.fixture
def said(tmp_path, monkeypatch):
    """Names a unit as a fresh process would, and tells whether pint was asked."""
    monkeypatch.setenv("APESIM_CACHE_DIR", str(tmp_path))

    def of(name):
        asked = []
        monkeypatch.setattr(names, "_asked", lambda name, ask=ASKED: asked.append(name) or ask(name))
        for function in (names.named, names._kept, names._said_by):
            function.cache_clear()
        return names.named(name), bool(asked)

    yield of
    names.named.cache_clear()
    names._kept.cache_clear()


def test_pint_is_asked_once(said):
    assert said("revolution") == (REVOLUTION, True)
    assert said("revolution") == (REVOLUTION, False)
    assert said("minute") == ((Fraction(60), (("second", 1),)), True)
    assert said("revolution") == (REVOLUTION, False)


def test_a_unit_that_was_met_before_does_not_load_pint(tmp_path):
    from tests.apesim.test_kernel import ROOT, python

    code = "import sys; from apesim.quantities import unit; print(unit('rpm').factor, 'pint' in sys.modules)"
    first, again = (python(code, ROOT, APESIM_CACHE_DIR=str(tmp_path)).split() for _ in range(2))
    assert first == [str(Fraction(2.0 * math.pi) / 60), "True"]
    assert again == [first[0], "False"]


@pytest.mark.parametrize("damage", ["", "garbage", "[]", '{"said by": 1}', '{"units": {}}', "truncated", "no fraction"])
def test_a_damaged_file_is_rebuilt(said, tmp_path, damage):
    said("revolution")
    path = tmp_path / "units" / "units.json"
    whole = path.read_text()
    changed = {"truncated": whole[: len(whole) // 2], "no fraction": whole.replace("/", "//")}.get(damage, damage)
    assert changed != whole
    path.write_text(changed)
    assert said("revolution") == (REVOLUTION, True)
    assert path.read_text() == whole


def test_what_another_pint_said_does_not_count(said, tmp_path):
    said("revolution")
    path = tmp_path / "units" / "units.json"
    content = json.loads(path.read_text())
    path.write_text(json.dumps(content | {"said by": "0.1 " + content["said by"]}))
    assert said("revolution") == (REVOLUTION, True)


def test_a_file_that_others_may_write_is_not_read(said, tmp_path):
    said("revolution")
    (tmp_path / "units").chmod(0o777)
    assert said("revolution") == (REVOLUTION, True)


def test_where_nothing_can_be_kept_pint_is_asked(said, tmp_path):
    (tmp_path / "units").write_text("a file, not a folder")
    assert said("revolution") == said("revolution") == (REVOLUTION, True)


def test_what_is_no_unit_is_wrong_each_time(said):
    for _ in range(2):
        with pytest.raises(Wrong):
            said("furlongest")
