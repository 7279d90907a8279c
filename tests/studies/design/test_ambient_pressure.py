"""The ambient pressure: absolute alone, as gauge pressures stand above it."""

import pytest

from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.design.machine_design import design_machine


@pytest.mark.parametrize(
    "read",
    [
        lambda text: Machine().with_(ambient_pressure=text),
        lambda text: Machine.load(None, [f"ambient.pressure={text}"]),
        lambda text: design_machine(ambient_pressure=text),
    ],
    ids=["from Python", "command line", "design"],
)
@pytest.mark.parametrize("text", ["93 kPa gauge", "93 kPa"])
def test_it_is_absolute_alone(read, text):
    with pytest.raises(InputError, match=r'write "93 kPa abs"$') as caught:
        read(text)
    assert "gauge" not in str(caught.value).rpartition("write")[2]
