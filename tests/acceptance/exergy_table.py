"""The exergy ledger of an independent solution, and ours beside it: 1000 r/min, 1.0 MPa gauge, receiver of 1 L."""

from apesim.engine.exergy import ENTERS, LEAVES
from apesim.engine.indicators import indicators
from apesim.engine.machine import Machine
from apesim.studies.timing import corrected
from tests.machines import RPM, machine, settled

COLUMNS = ("engine_air", "indicated_work", "feed", "groove", "exhaust", "mixing", "control_air")
EXPECTED = {
    "fixed": (756.1, 218.7, 18.6, 184.4, 321.7, 12.6, 86.9),
    "corrected": (346.1, 218.9, 2.8, 25.8, 97.7, 0.8, 75.9),
    "cam": (351.0, 222.9, 3.4, 23.4, 100.5, 0.9, 0.0),
    "ideal": (467.8, 279.6, 5.4, 26.6, 155.4, 0.8, 0.0),
}
"""J in a cycle; exhaust: throttling there and what the air carries off; mixing: in receiver and cylinder."""


def machine_of(case: str) -> Machine:
    """The machine of a row."""
    if case == "corrected":
        return corrected(machine(receiver=1.0), 1000.0 * RPM).machine
    return machine(receiver=1.0, intake="epv" if case == "fixed" else case)


def exergy_terms(case: str) -> dict[str, float]:
    """Terms of a row by the names of the columns [J], and how well the whole ledger closes."""
    a_machine = machine_of(case)
    found = indicators(a_machine, settled(a_machine, 1000.0))
    terms = {name: found[f"exergy_{name}_J"] for name in (*ENTERS, *LEAVES, "stored", "indicated_work")}
    terms["exhaust"] = terms["exhaust_valve"] + terms["exhaust_air"]
    terms["mixing"] = terms["receiver_mixing"] + terms["cylinder_mixing"]
    return {name: terms[name] for name in COLUMNS} | {"closure": found["exergy_closure"]}
