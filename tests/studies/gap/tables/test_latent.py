"""What a table says, over what it was made to depend on."""

import numpy as np
import pytest

from apesim.engine.effects import ALL_EFFECTS
from apesim.studies.gap.figures import draw_gap
from apesim.studies.gap.search.candidates import Candidate, make_strength
from apesim.studies.gap.tables.latent import Branch, find_branches
from tests.machines import machine
from tests.studies.gap.report.test_html import AMBIENT, compared
from tests.studies.gap.report.test_verdict_json import fitted

TABLES = {effect.name: effect for effect in ALL_EFFECTS if effect.tabulated}


def with_table(name, **nodes):
    """A model with some nodes of a table at x, and all of them as unsure as a whole range."""
    effect = TABLES[name]
    strengths = tuple(make_strength(effect, field) for field in effect.strengths)
    x = [nodes.get(field, 0.0) for field in effect.strengths]
    return fitted(machine(), [], list(strengths), x, (Candidate(name, strengths, ()),))


@pytest.mark.parametrize("name", TABLES)
def test_every_branch_says_what_it_is_and_over_what(name):
    found = find_branches(with_table(name, **dict.fromkeys(TABLES[name].strengths, 0.5)))
    assert [branch.name for branch in found] == list(
        dict.fromkeys(field.rsplit("_at_", 1)[0] for field in TABLES[name].strengths)
    )
    for branch in found:
        assert branch.abscissa.endswith("]")
        assert branch.unit in branch.quantity


def test_branches_that_moved_are_told_in_the_units_of_the_machine_file():
    (force,) = find_branches(with_table("tabulated_force", force_at_0=-0.5, force_at_100=0.25))
    assert (force.name, force.unit, force.quantity) == ("force", "N", "force to closed [N]")
    assert list(force.positions) == list(range(0, 101, 10))
    assert force.values[[0, 5, 10]] == pytest.approx([-20.0, 0.0, 10.0])
    assert force.standard_deviations == pytest.approx(40.0 / np.sqrt(2.0))
    (leak,) = find_branches(with_table("tabulated_leak", between_at_50=0.3))
    assert leak.values == pytest.approx([0.0, 0.3, 0.0])
    (heat,) = find_branches(with_table("tabulated_heat", a_at_minus_80=0.1))
    assert list(heat.positions) == [-80.0, -40.0, 0.0, 40.0, 80.0]
    assert find_branches(with_table("tabulated_force", force_at_0=0.005)) == []


def test_a_curve_goes_through_its_nodes_and_closes_over_a_turn():
    places, values = np.arange(0.0, 360.0, 30.0), np.sin(np.arange(12.0))
    turn = Branch("tabulated_cylinder_heat", "share", places, values, np.ones(12), "")
    at, curve = turn.interpolate()
    assert (at[0], at[-1], curve[0], curve[-1]) == (0.0, 360.0, values[0], pytest.approx(values[0]))
    assert np.interp(places, at, curve) == pytest.approx(values, abs=1e-9)
    speeds = np.array([0.0, 100.0, 300.0, 700.0, 1500.0, 3100.0])
    drag = Branch("tabulated_damping", "friction", speeds, np.sqrt(speeds), np.ones(6), "N")
    assert np.interp(speeds, *drag.interpolate()) == pytest.approx(np.sqrt(speeds), abs=0.2)
    late = Branch("tabulated_delay", "a", np.array([0.0, 50.0, 100.0]), np.array([0.0, 1.0, 0.0]), np.ones(3), "ms")
    assert np.interp([25.0, 75.0], *late.interpolate()) == pytest.approx([0.5, 0.5])


def test_what_a_table_says_is_drawn(tmp_path):
    one = find_branches(with_table("tabulated_damping", friction_at_100=0.3, seal_at_1000=0.4))
    draw_gap([compared(after=False)], [], "", AMBIENT, tmp_path, one)
    assert (tmp_path / "latent.png").stat().st_size > 5000
