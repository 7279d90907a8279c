"""apesim beside the independent simulator of tests/truth: bench, engines and corrected commands."""

import numpy as np

from docs.results import Number, Table
from tests.acceptance.independent_simulator import (
    MARCHED,
    bench_deviations,
    engine_deviations,
    random_machine,
    timing_misses,
    with_effect,
)
from tests.machines import machine

LONG = True
SEEDS = range(12)
TIMED = ((600.0, 1.0), (1000.0, 1.0), (1500.0, 0.6), (2100.0, 1.4))
"""Speeds [r/min] and supply pressures [MPa gauge]."""


def compute():
    """Largest deviations of the bench over all effects, of random engines, and misses of corrected commands."""
    bench = {"none": bench_deviations(machine(supply=0.4))}
    bench |= {effect.name: bench_deviations(with_effect(effect.name)) for effect in MARCHED}
    engines = [engine_deviations(*random_machine(seed)) for seed in SEEDS]
    quantities = list(dict.fromkeys(name for found in engines for name in found.shares))
    lines = []
    for name in quantities:
        found = [each.shares[name] for each in engines if name in each.shares]
        lines.append([name.replace("_", " "), Number(len(found)), Number(1e6 * max(found), error=0.05), "10⁻⁶"])
    turned = np.array([list(each.angles.values()) for each in engines if each.angles])
    lines.append(["angles of the valve", Number(len(turned)), Number(1e3 * turned.max(), error=0.005), "10⁻³ °"])
    misses = {at: timing_misses(at[0], supply=at[1]) for at in TIMED}
    return {
        "bench": Table(
            ["effect switched on", "lift [nm]", "pressure of A [10⁻⁶]", "temperature of B [10⁻⁶]"],
            [
                [
                    f"`{name}`" if name != "none" else "none",
                    Number(1e9 * found.lift, error=0.005),
                    Number(1e6 * found.pressure, error=0.005),
                    Number(1e6 * found.temperature, error=0.005),
                ]
                for name, found in bench.items()
            ],
        ),
        "effects": Number(len(MARCHED)),
        "largest_lift": Number(1e9 * max(found.lift for found in bench.values()), "nm", error=0.05),
        "largest_pressure": Number(1e6 * max(found.pressure for found in bench.values()), "·\u00a010⁻⁶", error=0.05),
        "largest_temperature": Number(
            1e6 * max(found.temperature for found in bench.values()), "·\u00a010⁻⁶", error=0.05
        ),
        "engines": Table(["result", "engines", "largest deviation", "unit"], lines),
        "engines_drawn": Number(len(SEEDS)),
        "largest_share": Number(1e6 * max(max(each.shares.values()) for each in engines), "·\u00a010⁻⁶", error=0.05),
        "largest_angle": Number(1e3 * float(turned.max()), "·\u00a010⁻³ °", error=0.005),
        "timing": Table(
            ["speed [r/min]", "supply [MPa gauge]", "opens off by [10⁻³ °]", "closes off by [10⁻³ °]"],
            [
                [f"{rpm:g}", f"{supply:g}", *(Number(1e3 * miss, error=0.005) for miss in misses[rpm, supply])]
                for rpm, supply in TIMED
            ],
        ),
        "largest_miss": Number(
            1e3 * max(abs(miss) for pair in misses.values() for miss in pair), "·\u00a010⁻³ °", error=0.005
        ),
    }
