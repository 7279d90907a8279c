"""Discrepancy: how far a model may be off in a channel, whatever its parameters, as a part of the noise.

With enough samples every real model fails a test of exactness. What a user calls good enough is a random function
beside the noise of the samples: Kennedy and O'Hagan 2001 (doi 10.1111/1467-9868.00294), here of a stated standard
deviation, half of its variance from sample to sample, half slow.
"""

from collections.abc import Mapping

from apesim.studies.estimation.noise.estimation import AllNoise


def state_discrepancy(noise: AllNoise, sizes: Mapping[str, float]) -> AllNoise:
    """The noise of sensors, by sampling interval, with the discrepancy of those of which one is stated [SI].

    >>> from apesim.studies.estimation.noise.process import white
    >>> before = {"force": {0.01: white(0.1, "stated")}, "lift": {0.01: white(3e-5, "stated")}}
    >>> noise = state_discrepancy(before, {"force": 0.3})
    >>> noise["force"][0.01].discrepancy, noise["lift"][0.01].discrepancy
    (0.3, 0.0)
    """
    return {
        sensor: {interval: one._replace(discrepancy=sizes.get(sensor, 0.0)) for interval, one in by_interval.items()}
        for sensor, by_interval in noise.items()
    }


def list_discrepancies(noise: AllNoise) -> dict[str, float]:
    """The discrepancies that are stated of sensors [SI], by sensor, of noise that `state_discrepancy` gives."""
    found = {sensor: max(one.discrepancy for one in by_interval.values()) for sensor, by_interval in noise.items()}
    return {sensor: size for sensor, size in found.items() if size}
