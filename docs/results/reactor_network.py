"""The cylinder beside a reactor network of Cantera that is given the same flows: largest relative deviations."""

from docs.results import Number, Table
from tests.acceptance.reactor_network import CASES, OVEREXPANDED, STEP, compared

WORDS = {
    "default": "default engine, {rpm:g} r/min",
    "back-flow": "flow back into the intake and in through the exhaust, {rpm:g} r/min",
}


def compute():
    """Deviations of pressure, temperature and work of each case."""
    rows, largest = [], {"pressure": 0.0, "temperature": 0.0, "work": 0.0}
    for case, (rpm, options) in CASES.items():
        found = compared(rpm, options)
        parts = {name: 1e6 * getattr(found, name) for name in largest}
        largest = {name: max(largest[name], parts[name]) for name in largest}
        rows.append([WORDS[case].format(rpm=rpm), *(Number(part, error=0.5) for part in parts.values())])
    heads = ["case", *(f"{name} [10⁻⁶]" for name in largest)]
    return {
        "cases": Table(heads, rows),
        **{f"largest_{name}": Number(part, "·\u00a010⁻⁶", error=0.5) for name, part in largest.items()},
        "flow_step": Number(STEP, "°", error=0.005),
        "overexpanded_supply": Number(OVEREXPANDED["supply"], "MPa gauge", error=0.05),
    }
