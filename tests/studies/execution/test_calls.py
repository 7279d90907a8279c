"""What the functions of the public face share."""

from apesim.engine.machine import Machine
from apesim.studies.execution.calls import compile_first


def test_a_machine_with_two_exhaust_valves_is_marched_first_though_one_with_one_was():
    marched = []

    def march(machine):
        marched.append(len(machine.engine.exhausts))

    areas = ("0 mm^2", "100 mm^2", "200 mm^2")
    for area in areas:
        compile_first(Machine().with_(**{"engine.exhaust_2.effective_area": area}), march)
    assert marched == [1, 2]
