"""What an effect says of its search is what the search does, for an effect of the library and for one from outside."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, Search
from apesim.engine.effects import ALL_EFFECTS
from apesim.engine.machine import Machine
from apesim.quantities import Quantity
from apesim.studies.gap.search.candidates import find_candidates, list_probes

OURS = {effect.name: effect for effect in ALL_EFFECTS}


class Drag(NamedTuple):
    force: Annotated[float, Quantity("N", 0, 10, "chosen")] = 0.0
    lift: Annotated[float, Quantity("N", 0, 20, "chosen")] = 0.0
    speed: Annotated[float, Quantity("m/s", 0.1, 2, "chosen")] = 1.0


def candidate(effect, bench="valve"):
    """The candidate of an effect on a machine without it."""
    effects = NamedTuple("Effects", [(effect.name, effect.parameters)])
    machine = Machine()._replace(effects=effects(effect.parameters()))
    found = find_candidates(machine, bench, [effect])
    return found[0] if found else None


def names(parameters):
    return [parameter.key.split(".")[-1] for parameter in parameters]


def drag(**search):
    texts = {"equation": "F", "source": "chosen", "seen_in": "flight", "isolated_by": "strokes", "layer": "valve"}
    return Effect("drag", Drag, **texts, strengths=("force", "lift"), search=Search(**search))


def test_without_a_word_all_strengths_are_searched_and_nothing_else():
    found = candidate(drag())
    assert (names(found.strengths), names(found.shapes)) == (["force", "lift"], [])
    assert [probe.x for probe in list_probes(found)][:2] == [(0.01, 0.0), (0.25, 0.0)]


def test_an_effect_from_outside_says_what_is_freed_and_by_how_much_it_is_probed():
    found = candidate(drag(shapes=("speed",), strengths=("force",), sizes=(0.5,)))
    assert (names(found.strengths), names(found.shapes)) == (["force"], ["speed"])
    assert {probe.x[0] for probe in list_probes(found)} == {0.5}
    assert all(parameter.outside is not None for parameter in found.parameters)


def test_a_shape_that_a_moved_cylinder_cannot_show_is_not_freed_there():
    shown = {bench: names(candidate(OURS["coulomb_friction"], bench).shapes) for bench in ("valve", "cylinder")}
    assert shown == {"valve": ["breakaway"], "cylinder": []}


def test_an_error_of_the_record_is_no_candidate_and_a_large_area_does_nothing():
    assert candidate(OURS["time_zero"]) is None
    (area,) = candidate(OURS["intake_pipe_loss"]).strengths
    assert area.inverse and area.value(1.0) == OURS["intake_pipe_loss"].search.min_area
