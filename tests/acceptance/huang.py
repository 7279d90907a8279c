"""A published engine run on air: C.-Y. Huang et al., Energies 2013, 6, 1731 (doi 10.3390/en6031731)."""

from collections.abc import Sequence

from apesim.engine.indicators import indicators
from apesim.engine.machine import Machine
from apesim.engine.steady import SteadyRun
from tests.folders import ROOT
from tests.machines import settled

MACHINE = ROOT / "docs" / "examples" / "data" / "huang.toml"
TORQUE_SPEED, POWER_SPEED = 465.0, 1320.0
"""Speeds of the highest torque and of the highest power [r/min]."""
SPEEDS = range(300, 2401, 50)
"""Speeds among which the highest power is looked for [r/min]."""


def point(rpm: float, settings: Sequence[str] = ()) -> tuple[dict[str, float], SteadyRun]:
    """Indicators and run of the engine at a speed [r/min], with settings as `--set` takes them."""
    machine = Machine.load(MACHINE, list(settings))
    run = settled(machine, rpm)
    return indicators(machine, run), run
