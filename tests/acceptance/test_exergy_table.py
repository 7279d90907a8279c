"""The exergy ledger against an independent solution (ideal air, 1000 r/min, 1.0 MPa gauge, receiver of 1 L).

Stated error: 0.5 % of each number or 0.2 J, as it is printed to 0.1 J.
"""

import pytest

from tests.acceptance.exergy_table import COLUMNS, EXPECTED, exergy_terms

ERROR, AMOUNT = 5e-3, 0.2


@pytest.mark.parametrize("case", EXPECTED)
def test_the_ledger_repeats_the_independent_solution(case):
    found = exergy_terms(case)
    wrong = {
        name: (found[name], number)
        for name, number in zip(COLUMNS, EXPECTED[case], strict=True)
        if abs(found[name] - number) > max(ERROR * number, AMOUNT)
    }
    assert not wrong
    assert found["closure"] < 1e-6
