"""Data like those of a laboratory's bench, from the independent simulator in ``tests/truth``, with nothing hidden.

From a checkout: ``PYTHONPATH=. python docs/examples/data/laboratory/make.py``. Friction, solenoid area and dead time
differ from the default machine; all else is as the machine file says.
"""

from pathlib import Path

from docs.examples.data.missing_effect.make import Reading, write_folder
from tests.truth.simulator.valve import Bench

RIG = Bench(viscous_friction=117.0, effective_area=8.8e-6, dead_time=1.55e-3)
RUNS = {0.16: "fit", 0.40: "fit", 0.49: "gate"}

if __name__ == "__main__":
    write_folder(Path(__file__).parent, RIG, RUNS, chambers=True, reading=Reading(), seed=1950)
