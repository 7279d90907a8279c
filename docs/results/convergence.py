"""Error against tolerance, and what a run states as its error beside how far it really is off."""

import numpy as np
from matplotlib.figure import Figure

from apesim.march.adaptive import TOLERANCE
from apesim.march.error_bounds import MAX_CLOSURE, MAX_EXERGY_CLOSURE, MAX_TOLERANCE_CHANGE
from docs.results import HERE, Number, Table
from tests.acceptance.convergence import FINEST, convergence_table
from tests.acceptance.random_engines import FINE, errors_of, random_errors
from tests.machines import machine

LONG = True
DRAWN = 400
"""Random engines."""
POINTS = {
    "EPV, 1000 r/min, receiver of 1 L": (1000.0, {"receiver": 1.0}),
    "cam, 1000 r/min, receiver of 1 L": (1000.0, {"receiver": 1.0, "intake": "cam"}),
    "ideal valve, 1000 r/min, receiver of 1 L": (1000.0, {"receiver": 1.0, "intake": "ideal"}),
    "EPV, 1500 r/min, receiver of 1 L": (1500.0, {"receiver": 1.0}),
    "EPV, 1500 r/min, receiver of 10 L": (1500.0, {"receiver": 10.0}),
    "EPV, 3000 r/min, endless receiver": (3000.0, {}),
}
POWERS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def compute():
    """Errors over the tolerance; errors stated and true of named points and of random engines; two figures."""
    tolerances, errors = convergence_table()
    _draw_convergence(tolerances, errors)
    worst = {case: np.max(list(results.values()), axis=0) for case, results in errors.items()}
    at = int(np.argmin(np.abs(np.log(tolerances / TOLERANCE))))
    values = {
        "multiples": Table(
            [
                "case",
                f"largest relative error at the default tolerance {_power(TOLERANCE)}",
                "largest error over tolerance, from 10⁻⁹ to 10⁻⁴ [1]",
            ],
            [
                [case, _power(error[at]), Number(float((error / tolerances)[tolerances > 0.9e-9].max()), error=0.05)]
                for case, error in worst.items()
            ],
        ),
    }
    named = {name: errors_of(machine(**options), rpm) for name, (rpm, options) in POINTS.items()}
    values["points"] = Table(
        ["operating point", "work: stated", "work: true", "air: stated", "air: true"],
        [[name, *map(_power, each[:4])] for name, each in named.items()],
    )
    return values | _random(list(random_errors(DRAWN)))


def _random(found):
    """Numbers of the random engines, for work and air apart."""
    stated, true = (
        np.array([(e.work_stated, e.air_stated) for e in found]),
        np.array([(e.work, e.air) for e in found]),
    )
    warned, closures = np.array([e.warned for e in found]), np.array([e.closures for e in found])
    calm, understated = ~warned[:, None], true > stated
    rows = [
        ["largest true error of a run without a warning", *_largest(true, calm)],
        [
            "median of stated over true error",
            *(Number(float(np.median(s[t > 0] / t[t > 0])), error=0.5) for s, t in zip(stated.T, true.T, strict=True)),
        ],
        ["runs whose true error is above the stated one", *(Number(int(n)) for n in understated.sum(axis=0))],
        ["largest true error of these, without a warning", *_largest(true, calm & understated)],
        ["largest true error of a run with a warning", *_largest(true, ~calm)],
    ]
    closure = [_power(largest) for largest in closures.max(axis=0)]
    return {
        "drawn": Number(DRAWN),
        "periodic": Number(len(found)),
        "warned": Number(int(warned.sum())),
        "largest": Number(1e5 * float(np.where(calm, true, 0.0).max()), "·\u00a010⁻⁵", error=0.05),
        "understated": Number(100.0 * float(understated.mean()), "%", error=0.5),
        "random": Table(["relative", "work of a cycle", "air of a cycle"], rows),
        "closures": Table(
            ["not accounted for over a cycle, largest", "relative", "a run warns from"],
            [
                ["mass", closure[0], _power(MAX_CLOSURE)],
                ["energy", closure[1], _power(MAX_CLOSURE)],
                ["exergy", closure[2], _power(MAX_EXERGY_CLOSURE)],
            ],
        ),
    }


def _largest(values, chosen):
    """Largest chosen value of each column, as text."""
    return [_power(value) for value in np.where(chosen, values, 0.0).max(axis=0)]


def _power(value):
    """A small number as text with one decimal and a power of ten."""
    if value == 0.0:
        return "0"
    exponent = int(np.floor(np.log10(value)))
    digits = f"{value / 10.0**exponent:.1f}"
    if digits == "10.0":
        digits, exponent = "1.0", exponent + 1
    return (f"{digits.removesuffix('.0')}·" if digits != "1.0" else "") + "10" + str(exponent).translate(POWERS)


def _draw_convergence(tolerances, errors):
    figure = Figure(figsize=(6.4, 9.6), layout="constrained")
    panels = figure.subplots(len(errors), 1, sharex=True, sharey=True)
    for axes, (name, results) in zip(panels, errors.items(), strict=True):
        for key, error in results.items():
            axes.loglog(tolerances, error, ".-", label=key)
        axes.loglog(tolerances, tolerances, "k:", label="error = tolerance")
        axes.axvline(TOLERANCE, color="0.7", lw=0.8, label="default tolerance")
        axes.set(title=name, ylabel=f"relative error against {FINEST:g} [1]")
        axes.legend(fontsize="small")
    panels[-1].set_xlabel("tolerance of a step [1]")
    figure.savefig(HERE / "convergence.png", dpi=110)


def _draw_stated(stated, true):
    figure = Figure(figsize=(6.4, 4.6), layout="constrained")
    axes = figure.subplots()
    floor = 1e-11
    for column, (name, mark) in enumerate((("work of the cycle", "o"), ("air of the cycle", "s"))):
        axes.loglog(
            np.maximum(stated[:, column], floor), np.maximum(true[:, column], floor), mark, ms=3, alpha=0.5, label=name
        )
    ends = np.array([floor, 1e-2])
    axes.loglog(ends, ends, "k:", label="true error = stated error")
    axes.axvline(MAX_TOLERANCE_CHANGE, color="C3", lw=1.0, label="a run warns from here on")
    axes.set(
        xlabel="stated: change at ten times the tolerance, relative [1]",
        ylabel=f"true: against a tolerance of {FINE:g}, relative [1]",
        xlim=(floor, None),
        ylim=(floor, None),
    )
    axes.legend(fontsize="small")
    figure.savefig(HERE / "stated_error.png", dpi=110)
