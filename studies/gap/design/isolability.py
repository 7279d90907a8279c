"""What sensors and operating points could show at all: from the runs alone, before any residual is looked at."""

import contextlib
import html
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy as np

from apesim.engine.machine import Machine
from apesim.studies.estimation.calibration import uncalibrated
from apesim.studies.estimation.levenberg_marquardt import Fitted
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.estimation.priors import describe_priors
from apesim.studies.estimation.residuals import EndedEarly, WhitenedResiduals
from apesim.studies.estimation.scatter import find_stated_scatter, find_stated_sizes
from apesim.studies.execution.calls import public
from apesim.studies.gap.design.experiments import Experiment, list_experiments, make_residuals
from apesim.studies.gap.input_checks import check_roles
from apesim.studies.gap.report.verdict_json import describe_noise
from apesim.studies.gap.search.candidates import Probe, find_candidates
from apesim.studies.gap.search.detection_limits import (
    find_detection_limits,
    format_limit,
    select_clearest,
    sharpen_probe,
)
from apesim.studies.gap.search.library import find_faults, select_effects
from apesim.studies.gap.search.score_test import Sensitivity, find_cosine, find_sensitivities
from apesim.studies.gap.stage_work import Work
from apesim.studies.gap.thresholds import ALIKE, N_SIGMA_VISIBLE
from apesim.studies.measured import Measured
from apesim.studies.measured.arguments import Tell, open_measured
from apesim.studies.measured.plausibility import refuse_faults

PRIORS_HEADER = ("number of the rig", "value", "known to (1 sigma)", "stated in, or reason")
"""Header of the table of what is known of the rig."""


@dataclass(frozen=True, eq=False, repr=False)
class Isolability:
    """What sensors and operating points could show, and what they could not distinguish.

    Attributes
    ----------
    effects : list of dict
        For each effect ``effect``, ``parameter``, ``unit``, ``limit`` (the size visible with 5 sigmas; None:
        beyond its range), ``off`` (the value without effect, from which the limit counts), ``grows`` ("down" where the
        effect is the larger the smaller the parameter), ``kept`` (the share that is left once the uncertain numbers of
        the machine are fitted), ``class`` (others that the data would hardly distinguish from it) and ``helped_by``
        (the experiment that would show it or split its class; None: none is needed, or none of the list would do).
    noise : dict
        See `apesim.studies.estimation.noise.estimation.noise_of`.
    warnings : list of str
    wall_time_s : float
        Computing time of the call [s].
    priors : list of dict
        What is known of the rig, see `apesim.studies.estimation.priors.describe_priors`.
    """

    effects: list[dict[str, Any]]
    noise: dict[str, Any]
    warnings: list[str]
    wall_time_s: float = 0.0
    priors: list[dict[str, Any]] = field(default_factory=list)

    @property
    def visible(self) -> list[str]:
        """Effects that the data could show."""
        return [row["effect"] for row in self.effects if row["limit"] is not None]

    @property
    def isolable(self) -> list[str]:
        """Effects that the data could show and distinguish from all others."""
        return [row["effect"] for row in self.effects if row["limit"] is not None and not row["class"]]

    def to_dict(self) -> dict[str, Any]:
        """The content of ``apesim gap isolability --json``.

        Returns
        -------
        dict

        Examples
        --------
        >>> row = {"effect": "side_force", "limit": 1.2, "unit": "N", "kept": 0.4, "class": []}
        >>> isolability = Isolability([row], noise={}, warnings=[])
        >>> isolability.to_dict()["effects"][0]["limit"], isolability.isolable
        (1.2, ['side_force'])
        """
        return {
            "effects": self.effects,
            "priors": self.priors,
            "noise": describe_noise(self.noise),
            "warnings": self.warnings,
            "wall_time_s": self.wall_time_s,
        }

    def __repr__(self) -> str:
        seen, alone = len(self.visible), len(self.isolable)
        counts = f"{seen} of {len(self.effects)} effects could be seen"
        return f"Isolability: {counts}, {alone} of them distinguishable from all others"

    def _repr_html_(self) -> str:
        effects = [
            (row["effect"], format_limit(row), f"{100.0 * row['kept']:.0f} %", ", ".join(row["class"]) or "-")
            for row in sorted(self.effects, key=lambda row: row["limit"] is None)
        ]
        header = ("effect", "visible from (5 sigmas)", "retained", "hardly distinguishable from")
        tables = _html_table(header, effects) + _html_table(PRIORS_HEADER, map(format_prior, self.priors))
        return f"{html.escape(repr(self))}{tables}"


def _html_table(header: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table for notebooks."""
    body = "".join(f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><tr>{''.join(f'<th>{cell}</th>' for cell in header)}</tr>{body}</table>"


def format_prior(prior: dict[str, Any]) -> tuple[str, str, str, str]:
    """A row, with cells under `PRIORS_HEADER`, of the table of what is known of the rig; see `describe_priors`.

    >>> prior = {"key": "valve.stroke", "value": 9.0, "unit": "mm", "known_to": "1 %", "stated_in": "measured.toml"}
    >>> format_prior(prior | {"reason": ""})
    ('valve.stroke', '9 mm', '1 %', 'measured.toml')
    """
    value = "of each run" if prior["value"] is None else f"{prior['value']:.5g} {prior['unit']}".strip()
    why = ": ".join(part for part in (prior["stated_in"], prior["reason"]) if part)
    return prior["key"], value, prior["known_to"], why


@public
def find_isolability(
    machine: Machine,
    measured: Measured | str | PathLike[str],
    *,
    without: Sequence[str] = (),
    progress: Tell | None = None,
) -> Isolability:
    """Find which effects the data could show, from which size on, and which of them they could not distinguish.

    Parameters
    ----------
    machine : Machine
    measured : Measured or path
        Measured data, see `read_measured`, or their folder. What was measured is used for the noise alone.
    without : sequence of str
        Effects of the library that are left out.
    progress : callable, optional
        Called with the name of the stage, what is done of it and what there is to do.

    Returns
    -------
    Isolability

    Raises
    ------
    InputError
        An argument is wrong, or nothing can be concluded from the data.
    NotConverged
        The machine itself cannot be simulated.

    Examples
    --------
    Lift of a valve at two supply pressures, and a small part of the library; of your own data, give the folder.

    >>> import apesim
    >>> from apesim.studies.gap.example_bench import list_left_out, read_example
    >>> isolability = apesim.find_isolability(apesim.Machine(), read_example(), without=list_left_out())
    >>> isolability.visible
    ['coulomb_friction', 'side_force']
    """
    start = time.perf_counter()
    machine, measured, _ = open_measured("find_isolability", machine, measured, faults=find_faults(without, machine))
    check_roles(measured)
    warnings = refuse_faults(None, measured)
    rows, noise, more = _isolability(machine, measured, without, Work(tell=progress))
    priors = describe_priors(machine, measured)
    return Isolability(rows, noise, [*warnings, *more], time.perf_counter() - start, priors)


def _isolability(
    machine: Machine, measured: Measured, without: Sequence[str], work: Work
) -> tuple[list[dict[str, Any]], dict[str, Any], list[str]]:
    """Rows, noise and warnings of `Isolability`."""
    residuals, warnings = uncalibrated(machine, measured, work.simulations)

    # All is taken at the machine as it is, which stands for a fit: what was measured is used for the noise alone.
    nominal = np.zeros(len(residuals.parameters))
    stated = find_stated_sizes(machine, measured, residuals.parameters)
    residuals, errors, jacobian, steps = _find_slopes(residuals, stated, nominal)

    # Each effect by the probe that shows it best, at the very size from which it is seen.
    candidates = find_candidates(machine, measured.bench, select_effects(measured.bench, without, machine))
    fitted = Fitted(nominal, errors, jacobian, True, steps)
    columns = find_sensitivities(residuals, fitted, candidates, work, "effects")
    best = {name: sharpen_probe(residuals, fitted, column) for name, column in select_clearest(columns).items()}
    limits = find_detection_limits(list(best.values()))

    # What an experiment could help: effects that are hidden, and those that are not distinguished from others.
    n = len(errors) - len(nominal)
    effects = {name: column.effect[:n] for name, column in best.items()}
    classes = {name: limit["class"] for name, limit in limits.items() if limit["limit"] is not None}
    wanted = [name for name in best if name not in classes or classes[name]]
    wanted += [other for name in wanted for other in classes.get(name, ()) if other not in wanted]
    probes = {name: (best[name].probe, effects[name]) for name in wanted}

    # Each experiment is simulated once for all of these effects; one that ends early helps none.
    outcomes: dict[str, list[tuple[Experiment, float, float]]] = {name: [] for name in wanted}
    experiments = list_experiments(measured, machine.ambient.pressure) if wanted else []
    for done, experiment in enumerate(experiments, 1):
        with contextlib.suppress(EndedEarly):
            wider = add_experiment(experiment, residuals, nominal, jacobian[:n], probes, stated)
            for name in wanted:
                outcomes[name].append((experiment, *compare_with_class(name, wider, classes.get(name, ()), best)))
        work.tell("experiments", done, len(experiments))
    rows = [
        {"effect": name, **limit, "helped_by": _choose_experiment(outcomes.get(name, []), classes.get(name), limit)}
        for name, limit in limits.items()
    ]
    return rows, residuals.noise, warnings


def _find_slopes(
    residuals: WhitenedResiduals, stated: Mapping[str, float], x: np.ndarray
) -> tuple[WhitenedResiduals, np.ndarray, np.ndarray, np.ndarray]:
    """Residuals with the stated scatter, and their values, sensitivities and adapted steps at parameters x (p,).

    `residuals` come without scatter, `stated` is the scatter between runs by `find_stated_sizes`; errors are (n + p,),
    the Jacobian (n + p, p), its steps (p,).
    """
    errors = residuals.at(x)
    _, steps = residuals.jacobian(x, errors)
    jacobian, steps = residuals.jacobian(x, errors, steps)
    scatter = find_stated_scatter(residuals, jacobian, stated)
    if scatter is None:
        return residuals, errors, jacobian, steps
    n = len(errors) - len(x)
    rows = residuals.change_scatter(np.column_stack([errors, jacobian])[:n], scatter)
    errors, jacobian = np.append(rows[:, 0], errors[n:]), np.vstack([rows[:, 1:], jacobian[n:]])
    return residuals.with_scatter(scatter), errors, jacobian, steps


def add_experiment(
    experiment: Experiment,
    residuals: WhitenedResiduals,
    x: np.ndarray,
    jacobian: np.ndarray,
    wanted: dict[str, tuple[Probe, np.ndarray]],
    stated: Mapping[str, float],
) -> dict[str, np.ndarray]:
    """Changes (m,) of the data and of an experiment together by effects, by name, nuisances projected out.

    `residuals` are those of the data that there are, as a function of the nuisances, `jacobian` (n, p) their
    sensitivities at the nuisances x (p,); `wanted` holds probes and the changes (n,) of those data by them; `stated` is
    the scatter between runs, see `find_stated_sizes`. Raises EndedEarly where a simulation does not come to its end.
    """
    more = make_residuals(experiment, residuals.machine, residuals.parameters, residuals.noise)
    x = np.append(x, np.zeros(len(more.parameters) - len(x)))
    more, errors, slopes, _ = _find_slopes(more, stated, x)
    samples = len(errors) - len(x)
    old = np.column_stack([jacobian, np.zeros((len(jacobian), len(x) - jacobian.shape[1]))])
    space = find_nuisance_space(np.vstack([old, slopes[:samples], np.diag(more.known.astype(float))]))
    changes = {}
    for name, (probe, effect) in wanted.items():
        with_it = more.with_parameters([*more.parameters, *probe.candidate.parameters])
        shown = with_it.at(np.append(x, probe.x))[:samples] - errors[:samples]
        changes[name] = space.project_out(np.concatenate([effect, shown, np.zeros(len(x))]))
    return changes


def compare_with_class(
    name: str, changes: dict[str, np.ndarray], class_names: Sequence[str], best: dict[str, Sensitivity]
) -> tuple[float, float]:
    """The largest cosine with another of its class, and the size over the range that is visible, with more data."""
    alike = max((abs(find_cosine(changes[name], changes[other])) for other in class_names), default=0.0)
    probe = best[name].probe
    length = float(np.linalg.norm(changes[name]))
    return alike, abs(probe.x[probe.strength]) * N_SIGMA_VISIBLE / length if length else np.inf


def _choose_experiment(
    outcomes: list[tuple[Experiment, float, float]], class_names: Sequence[str] | None, limit: dict[str, Any]
) -> dict[str, Any] | None:
    """The experiment that would distinguish an effect from its class, or show it at all.

    Its ``cosine`` is that with the nearest of the class, its limit counts over the range. None: nothing is needed, or
    no experiment of the list would do.
    """
    if limit["limit"] is None:
        shown = [(size, alike, e) for e, alike, size in outcomes if size <= 1.0]
        chosen = min(shown, key=lambda row: row[0], default=None)
    elif class_names:
        distinguishing = [(size, alike, e) for e, alike, size in outcomes if alike <= ALIKE]
        chosen = min(distinguishing, key=lambda row: row[1], default=None)
    else:
        return None
    return chosen and {"text": chosen[2].text, "cosine": chosen[1], "limit_of_range": chosen[0]}
