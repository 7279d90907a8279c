"""What the default engine does at operating points with one change each, kept in a folder for all cases."""

from hashlib import sha256
from pathlib import Path

import numpy as np

from tests.truth.simulator.crank import TURN
from tests.truth.simulator.sensors import TRACES, Sensors, engine_channels

from .setting import SUITES

SAMPLES = 720
"""Per turn; those of a case are among them."""


class Bank:
    """A folder of engine runs."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)

    def channels(self, label, point, samples, run):
        """Channels of a run with faultless sensors, SI.

        Parameters
        ----------
        label : str
            Of the change, other for each.
        point : truth.sealed.setting.Point
        samples : int
            Per turn.
        run : callable
            Makes the run where it is not there yet.

        Returns
        -------
        dict of (samples,) float array or float
        """
        name = f"{label} {point.supply:.0f} {point.temperature:.2f} {point.speed:.6f}"
        path = self.folder / f"{sha256(name.encode()).hexdigest()[:24]}.npz"
        if not path.exists():
            angles = np.arange(SAMPLES) * (TURN / SAMPLES)
            found = engine_channels(run(), angles, Sensors(), SUITES["all"])
            part = path.with_suffix(f".{np.random.default_rng().integers(1 << 40)}.npz")
            np.savez(part, **found)
            part.replace(path)
        with np.load(path) as kept:
            return {name: kept[name][:: SAMPLES // samples] if name in TRACES else float(kept[name]) for name in kept}
