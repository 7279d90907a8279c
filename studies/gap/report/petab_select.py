"""The search as a model space of PEtab Select: the models that were open to it, and those that were fitted.

Format: https://petab-select.readthedocs.io, version 1.0.0 of its files.

Every pair of effects is in the space; the search fits the likeliest of them, and none where one effect closes the gap.
The simulator is no PEtab problem: ``petab_problem.yaml``, which the format asks for, names a table of parameters and
neither model nor measurements. That is enough to count parameters and priors and to read fitted models back, not to fit
further ones. A nuisance whose prior was taken away is not among the models, as priors stand in that table, which all of
them share; nor is a table in place of a law, which is no effect of the library.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from math import log
from typing import TYPE_CHECKING, Any

from apesim.quantities.units import unit
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.parameters import Parameter, value_at, value_of
from apesim.studies.gap.search.candidates import Candidate
from apesim.studies.gap.search.run_faults import find_files

if TYPE_CHECKING:
    from apesim.studies.gap.explanation import Explanation

ESTIMATE = "estimate"
CALIBRATED = "calibrated_machine"
"""Name of the model that adds nothing."""
PROBLEM, PARAMETERS, SPACE = "petab_problem.yaml", "parameters.tsv", "model_space.tsv"
CRITERION = "BIC"
"""The heavier of those that count parameters. The search has its own penalty, see
`apesim.studies.gap.search.model_selection.find_penalty`, and looks at runs held out: the best model by this one need
not be the verdict."""
NOTE = """\
# Values in SI; units stand in parameters.tsv.
# NLLH: half the sum of squares over the noise, priors included; a constant that all models share is left out.
"""


def export_model_space(explanation: "Explanation") -> dict[str, str]:
    """Export the models that were searched, as texts by the name of the file of PEtab Select."""
    base, candidates = explanation.calibrated, list_candidates(explanation)
    freed = [parameter for candidate in candidates for parameter in candidate.parameters]
    nominal = {format_id(p): value_of(base.residuals.machine, p.key) for p in freed}
    # A fault of one file is no model of the rig.
    tried = [c.model for c in explanation.fits if not find_files(c.model.candidates)]
    fitted = [base, *tried]

    # All that was open to the search, fitted or not: singles and pairs, and the larger sets that it went on to.
    models: list[tuple[Candidate, ...]] = [
        (),
        *((candidate,) for candidate in candidates),
        *combinations(candidates, 2),
        *(model.candidates for model in tried if len(model.candidates) > 2),
    ]

    # A model is known by the set of its effects, as the search may have added them in another order.
    spaces = {frozenset(_list_names(added)): (_name_model(added), _list_settings(nominal, added)) for added in models}
    rows = [(name, PROBLEM, *settings.values()) for name, settings in spaces.values()]
    problem = {
        "format_version": "1.0.0",
        "criterion": CRITERION,
        "method": "brute_force",
        "model_space_files": [SPACE],
    }

    # The simulator is no PEtab problem: the lists of its files are empty, and there as the format asks for them.
    nothing: dict[str, list[str]] = {
        kind: [] for kind in ("sbml_files", "condition_files", "observable_files", "measurement_files")
    }
    return {
        SPACE: _format_table(("model_subspace_id", "model_subspace_petab_yaml", *nominal), rows),
        PARAMETERS: _format_parameters(base, freed),
        PROBLEM: format_yaml({"format_version": 1, "parameter_file": PARAMETERS, "problems": [nothing]}),
        "petab_select_problem.yaml": format_yaml(problem),
        "calibrated_models.yaml": NOTE + "".join(_format_model(*spaces[frozenset(m.names)], m) for m in fitted),
    }


def list_candidates(explanation: "Explanation") -> list[Candidate]:
    """The candidates that these data can show and that were scored, in the order of the library."""
    return list({each.probe.candidate.name: each.probe.candidate for each in explanation.sensitivities}.values())


def _name_model(candidates: Iterable[Candidate]) -> str:
    """The name of a model, as PEtab Select's files call it."""
    return "__".join(_list_names(candidates)) or CALIBRATED


def format_id(parameter: Parameter) -> str:
    """The key of a parameter as PEtab allows it; a nuisance has a prefix, as an effect may share its key."""
    return "nuisance__" * parameter.prior + parameter.key.replace(".", "__")


def find_criteria(model: Model) -> dict[str, float]:
    """NLLH, AIC and BIC of a fitted model; a prior counts as a measurement.

    The criteria are those of Akaike (1974, doi 10.1109/TAC.1974.1100705) and Schwarz (1978, doi
    10.1214/aos/1176344136).

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> criteria = find_criteria(explain_example().best)
    >>> criteria["NLLH"] == explain_example().best.cost / 2.0
    True
    """
    freed = len(model.fitted.x)
    measured = len(model.fitted.residuals) - freed + int(model.residuals.known.sum())
    return {"NLLH": model.cost / 2.0, "AIC": model.cost + 2.0 * freed, "BIC": model.cost + freed * log(measured)}


def _list_names(candidates: Iterable[Candidate]) -> list[str]:
    """Names of candidates."""
    return [candidate.name for candidate in candidates]


def _list_settings(nominal: Mapping[str, Any], added: Iterable[Candidate]) -> dict[str, Any]:
    """Setting of each parameter in a model: estimated, or the machine's own value where its effect is off."""
    freed = {format_id(parameter) for candidate in added for parameter in candidate.parameters}
    return {name: ESTIMATE if name in freed else value for name, value in nominal.items()}


def _format_model(name: str, settings: Mapping[str, Any], model: Model) -> str:
    """An entry for a fitted model."""
    machine = model.residuals.machine
    fitted = zip(model.residuals.parameters, model.fitted.x, strict=True)
    entry = {
        "model_subspace_id": name,
        "model_subspace_indices": [0] * len(settings),
        "model_subspace_petab_yaml": PROBLEM,
        "model_id": name,
        "criteria": find_criteria(model),
        "parameters": settings,
        "estimated_parameters": {format_id(p): value_at(machine, p, x) for p, x in fitted},
    }
    return "- " + format_yaml(entry).rstrip("\n").replace("\n", "\n  ") + "\n"


def _format_parameters(base: Model, freed: Iterable[Parameter]) -> str:
    """PEtab's table of parameters: nuisances with their priors, and those of effects, which are off."""
    machine = base.residuals.machine
    rows = []
    for p in (*base.residuals.parameters, *freed):
        mean = value_of(machine, p.key)
        low, high = sorted(value_at(machine, p, end) for end in (p.low, p.high))
        prior = ("normal", f"{mean!r};{abs(value_at(machine, p, 1.0) - mean)!r}") if p.prior else ("", "")
        name = f"{p.key} [{unit(p.declaration.unit).si_text}]"  # type: ignore[attr-defined]
        rows.append((format_id(p), name, "lin", low, high, mean, int(p.prior), *prior))
    columns = ("parameterId", "parameterName", "parameterScale", "lowerBound", "upperBound", "nominalValue")
    return _format_table((*columns, ESTIMATE, "objectivePriorType", "objectivePriorParameters"), rows)


def _format_table(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table with tabs between its columns."""
    return "".join("\t".join(map(str, row)) + "\n" for row in (header, *rows))


def format_yaml(value: Mapping[str, Any]) -> str:
    """A mapping as YAML; mappings in it are indented, all else stands in its line."""
    lines = []
    for key, inner in value.items():
        if isinstance(inner, dict):
            lines += [f"{key}:", *(f"  {line}" for line in format_yaml(inner).splitlines())]
        else:
            lines.append(f"{key}: {_format_scalar(inner)}")
    return "".join(f"{line}\n" for line in lines)


def _format_scalar(value: Any) -> str:
    """A number as JSON, but for powers of ten: YAML 1.1 reads no number in 1e-05."""
    text = json.dumps(value, allow_nan=False)
    return text.replace("e", ".0e") if isinstance(value, float) and "." not in text else text
