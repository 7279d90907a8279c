"""The exergy ledger against an independent solution (ideal air, 1000 r/min, 1.0 MPa gauge, receiver of 1 L).

Stated error: 0.5 % of each number or 0.2 J, as it is printed to 0.1 J.
"""

import pytest

from apesim.engine.exergy import ENTERS, LEAVES
from apesim.engine.indicators import indicators
from apesim.studies.timing import corrected
from tests.machines import RPM, machine, settled

ERROR, AMOUNT = 5e-3, 0.2
COLUMNS = ("engine_air", "indicated_work", "feed", "groove", "exhaust", "mixing", "control_air")
EXPECTED = {
    "uncorrected": (756.1, 218.7, 18.6, 184.4, 321.7, 12.6, 86.9),
    "corrected": (346.1, 218.9, 2.8, 25.8, 97.7, 0.8, 75.9),
    "cam": (351.0, 222.9, 3.4, 23.4, 100.5, 0.9, 0.0),
    "ideal": (467.8, 279.6, 5.4, 26.6, 155.4, 0.8, 0.0),
}
"""J in a cycle; exhaust: throttling there and what the air carries off; mixing: in receiver and cylinder."""


def machine_of(case):
    if case == "corrected":
        return corrected(machine(receiver=1.0), 1000.0 * RPM).machine
    return machine(receiver=1.0, intake="epv" if case == "uncorrected" else case)


@pytest.mark.parametrize("case", EXPECTED)
def test_the_ledger_repeats_the_independent_solution(case):
    a_machine = machine_of(case)
    found = indicators(a_machine, settled(a_machine, 1000.0))
    term = {name: found[f"exergy_{name}_J"] for name in (*ENTERS, *LEAVES, "stored", "indicated_work")}
    term["exhaust"] = term["exhaust_valve"] + term["exhaust_air"]
    term["mixing"] = term["receiver_mixing"] + term["cylinder_mixing"]
    wrong = {
        name: (term[name], number)
        for name, number in zip(COLUMNS, EXPECTED[case], strict=True)
        if abs(term[name] - number) > max(ERROR * number, AMOUNT)
    }
    assert not wrong
    assert found["exergy_closure"] < 1e-6
