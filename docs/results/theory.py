"""Constants of the flow function, priors and thresholds, as the code has them."""

from apesim.engine.stated_uncertainties import name_key
from apesim.flow_function import choked_flow_function, critical_ratio
from apesim.studies.estimation.model import MAX_PULL
from apesim.studies.estimation.parameters import DECLARED, shown
from apesim.studies.estimation.priors import CYLINDER, ENGINE, VALVE
from apesim.studies.gap import thresholds as t
from docs.results import Number, Table

LIVE = True

K = 1.4


def compute():
    """Values that the theory pages quote from the code."""
    priors = []
    for bench, of_bench in (("valve and engine", VALVE), ("engine", ENGINE), ("cylinder", CYLINDER)):
        for prior in of_bench:
            unit = DECLARED[prior.key].unit
            own = f"{shown(DECLARED[prior.key], prior.deviation):.3g} {unit}".strip()
            size = f"{100.0 * prior.deviation:g} %" if prior.relative else own
            priors.append([f"`{name_key(prior.key)}`", size, bench, prior.reason])
    decided = [
        ["first condition: chance of noise alone", f"below {t.ALARM:g}"],
        ["second condition: size of the gap, over the noise", f"{t.TOLERANCE:g} or more"],
        ["a nuisance is itself a finding", f"beyond {MAX_PULL:g} prior standard deviations"],
        ["two models are indistinguishable", f"penalised costs within {t.AMBIGUOUS_COST:.3g}"],
        ["two effects are of one class", f"cosine above {t.ALIKE:g}"],
        ["share of the gap removed on held-out runs", f"{t.MIN_REMOVED:g} or more"],
        [
            "size of the gap left on held-out runs",
            f"at most the tolerance of the second condition, or {100.0 * t.MAX_LEFT:g} % of the size before",
        ],
        ["a name against the machine without it", f"{t.AMBIGUOUS_COST:.3g} of penalised cost ahead, or more"],
        ["what is left of the fitted runs: chance of noise alone", f"{t.ALARM:g} or more"],
        ["log odds of each of several effects, with its twins", f"{t.MIN_LOG_ODDS:g} or more"],
        ["odds of each of several effects against its twins", f"{t.MIN_TWIN_ODDS:g} or more"],
        ["odds of what is sure of an ambiguous gap, with its twins", f"{t.MIN_SURE_ODDS:g} or more"],
        ["a table without a name refuses a name", f"at {t.TABLE_MARGIN:.2g} of penalised cost ahead of it"],
    ]
    return {
        "critical_ratio": Number(float(critical_ratio(K)), error=0.0005),
        "choked_flow_function": Number(float(choked_flow_function(K)), error=0.0005),
        "priors": Table(["number of the rig", "standard deviation of its prior", "data of", "reason"], priors),
        "thresholds": Table(["what is judged", "threshold"], decided),
    }
