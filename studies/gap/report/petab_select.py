"""The search as a model space of PEtab Select: the models that were open to it, and those that were fitted.

Format: https://petab-select.readthedocs.io, version 1.0.0 of its files.

Every pair of effects is in the space; the search fits the likeliest of them, and none where one effect closes the gap.
The simulator is no PEtab problem: ``petab_problem.yaml``, which the format asks for, names a table of parameters and
neither model nor measurements. That is enough to count parameters and priors and to read fitted models back, not to fit
further ones. A nuisance whose prior was taken away is not among the models, as priors stand in that table, which all of
them share; nor is a table in place of a law, which is no effect of the library.
"""

import json
from itertools import combinations
from math import log

from apesim.quantities.units import unit
from apesim.studies.estimation.parameters import value_at, value_of

ESTIMATE = "estimate"
CALIBRATED = "calibrated_machine"
"""Name of the model that adds nothing."""
PROBLEM, PARAMETERS, SPACE = "petab_problem.yaml", "parameters.tsv", "model_space.tsv"
CRITERION = "BIC"
"""The heavier of those that count parameters. The search has its own penalty, see
`apesim.studies.gap.search.model_selection.penalty`, and looks at runs held out: the best model by this one need not be
the verdict."""
NOTE = """\
# Values in SI; units stand in parameters.tsv.
# NLLH: half the sum of squares over the noise, priors included; a constant that all models share is left out.
"""


def model_space(explanation):
    """What was searched, in the files of PEtab Select.

    Parameters
    ----------
    explanation : apesim.studies.gap.explanation.Explanation

    Returns
    -------
    dict of str
        Text by the name of the file.
    """
    base, candidates = explanation.calibrated, open_to_the_search(explanation)
    freed = [parameter for candidate in candidates for parameter in candidate.parameters]
    own = {id_of(p): value_of(base.residuals.machine, p.key) for p in freed}
    models = [(), *((candidate,) for candidate in candidates), *combinations(candidates, 2)]
    spaces = {frozenset(_names(added)): (name_of(added), _settings(own, added)) for added in models}
    fitted = [base, *(choice.model for choice in explanation.fits if not choice.model.released)]
    rows = [(name, PROBLEM, *settings.values()) for name, settings in spaces.values()]
    problem = {
        "format_version": "1.0.0",
        "criterion": CRITERION,
        "method": "brute_force",
        "model_space_files": [SPACE],
    }
    nothing = {kind: [] for kind in ("sbml_files", "condition_files", "observable_files", "measurement_files")}
    return {
        SPACE: _tsv(("model_subspace_id", "model_subspace_petab_yaml", *own), rows),
        PARAMETERS: _parameters(base, freed),
        PROBLEM: yaml_of({"format_version": 1, "parameter_file": PARAMETERS, "problems": [nothing]}),
        "petab_select_problem.yaml": yaml_of(problem),
        "calibrated_models.yaml": NOTE + "".join(_entry(*spaces[frozenset(m.names)], m) for m in fitted),
    }


def open_to_the_search(explanation):
    """The candidates that these data can show and that were scored, in the order of the library.

    Returns
    -------
    list of apesim.studies.gap.search.candidates.Candidate
    """
    return list({column.probe.candidate.name: column.probe.candidate for column in explanation.sensitivities}.values())


def name_of(candidates):
    """Return the name of a model, as PEtab Select's files call it."""
    return "__".join(_names(candidates)) or CALIBRATED


def id_of(parameter):
    """A key as PEtab allows it; a nuisance is told from an effect on the same key, as is the angle of the TDC."""
    return "nuisance__" * parameter.prior + parameter.key.replace(".", "__")


def criteria_of(model):
    """NLLH, AIC and BIC of a fitted model; a prior counts as a measurement.

    The criteria are Akaike's [1]_ and Schwarz's [2]_.

    Returns
    -------
    dict of float

    References
    ----------
    .. [1] H. Akaike, "A new look at the statistical model identification", IEEE Trans. Automat. Contr. 19, 1974,
       pp. 716-723, doi 10.1109/TAC.1974.1100705.
    .. [2] G. Schwarz, "Estimating the dimension of a model", Ann. Statist. 6, 1978, pp. 461-464,
       doi 10.1214/aos/1176344136.
    """
    freed = len(model.fitted.x)
    measured = len(model.fitted.residuals) - freed + int(model.residuals.known.sum())
    return {"NLLH": model.cost / 2.0, "AIC": model.cost + 2.0 * freed, "BIC": model.cost + freed * log(measured)}


def _names(candidates):
    return [candidate.name for candidate in candidates]


def _settings(own, added):
    """What a model makes of each parameter: estimated, or as the machine has it, where its effect is off."""
    freed = {id_of(parameter) for candidate in added for parameter in candidate.parameters}
    return {name: ESTIMATE if name in freed else value for name, value in own.items()}


def _entry(name, settings, model):
    """A fitted model."""
    machine = model.residuals.machine
    fitted = zip(model.residuals.parameters, model.fitted.x, strict=True)
    entry = {
        "model_subspace_id": name,
        "model_subspace_indices": [0] * len(settings),
        "model_subspace_petab_yaml": PROBLEM,
        "model_id": name,
        "criteria": criteria_of(model),
        "parameters": settings,
        "estimated_parameters": {id_of(p): value_at(machine, p, x) for p, x in fitted},
    }
    return "- " + yaml_of(entry).rstrip("\n").replace("\n", "\n  ") + "\n"


def _parameters(base, freed):
    """PEtab's table of parameters: nuisances with their priors, and those of effects, which are off."""
    machine = base.residuals.machine
    rows = []
    for p in (*base.residuals.parameters, *freed):
        mean = value_of(machine, p.key)
        low, high = sorted(value_at(machine, p, end) for end in (p.low, p.high))
        prior = ("normal", f"{mean!r};{abs(value_at(machine, p, 1.0) - mean)!r}") if p.prior else ("", "")
        name = f"{p.key} [{unit(p.declaration.unit).si_text}]"
        rows.append((id_of(p), name, "lin", low, high, mean, int(p.prior), *prior))
    columns = ("parameterId", "parameterName", "parameterScale", "lowerBound", "upperBound", "nominalValue")
    return _tsv((*columns, ESTIMATE, "objectivePriorType", "objectivePriorParameters"), rows)


def _tsv(header, rows):
    return "".join("\t".join(map(str, row)) + "\n" for row in (header, *rows))


def yaml_of(value):
    """A mapping as YAML; mappings in it are indented, all else stands in its line."""
    lines = []
    for key, inner in value.items():
        if isinstance(inner, dict):
            lines += [f"{key}:", *(f"  {line}" for line in yaml_of(inner).splitlines())]
        else:
            lines.append(f"{key}: {_scalar(inner)}")
    return "".join(f"{line}\n" for line in lines)


def _scalar(value):
    """Write a number as JSON, but for powers of ten: YAML 1.1 reads no number in 1e-05."""
    text = json.dumps(value, allow_nan=False)
    return text.replace("e", ".0e") if isinstance(value, float) and "." not in text else text
