"""Results of one run: its numbers are scalars, and its traces have no axis of runs."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.columns import NO_YES, column
from apesim.archive.grid import words_of
from apesim.results import Scalar, Trace, name_of
from apesim.studies.archives.archive_result import ArchiveResult, variables_of

CONDITIONS = "conditions"
"""Entry of the provenance with the conditions of a run: JSON, a text by name."""


@dataclass(frozen=True, eq=False, repr=False)
class RunResult(ArchiveResult):
    """Result of one run, from its archive: numbers over the run are scalars, all else are traces."""

    @classmethod
    def _scalars_of(cls, archive: Archive, failed: Sequence[str]) -> Mapping[str, Scalar]:
        """Take the variables over the run alone: flags are true or false, other codes words."""
        return {
            name_of(name, variable.unit): Scalar(_value_of(variable), variable.unit, variable.description)
            for name, variable in archive.variables.items()
            if variable.dims == ("run",) and name != "run"
        }

    @classmethod
    def _traces_of(cls, archive: Archive) -> Mapping[str, Trace]:
        """Take the variables with other axes, without the axis of the one run."""
        return {
            name: trace
            if trace.dims == (name,)
            else Trace(trace.dims[1:], trace.values[0], trace.unit, trace.long_name)
            for name, trace in variables_of(archive).items()
            if name != "run" and trace.dims != ("run",)
        }

    @classmethod
    def _conditions_of(cls, archive: Archive) -> Mapping[str, str]:
        """Read the conditions of the run from the provenance."""
        conditions = json.loads(archive.provenance[CONDITIONS])
        return {str(name): str(text) for name, text in conditions.items()}


def _value_of(variable: Variable) -> Any:
    """Value of a variable of one run."""
    if variable.meanings == NO_YES:
        return bool(variable.values[0])
    return words_of(variable)[0].item()


def columns_of_run(values: Mapping[str, Any], declared: Mapping[str, tuple[str, str]]) -> dict[str, Variable]:
    """Make variables of an archive from the numbers of one run; `declared` has unit and long name by key."""
    return {key: column([value], *declared[key]) for key, value in values.items()}


def over_run(dims: tuple[str, ...], values: np.ndarray, unit: str, description: str, meanings: str = "") -> Variable:
    """Make a variable of an archive from values of one run, which lie over the axes `dims`."""
    return Variable(("run", *dims), np.asarray(values)[np.newaxis], unit, description, meanings)


def axis_of(name: str, values: np.ndarray, unit: str, description: str) -> dict[str, Variable]:
    """Make the axis `name` of an archive."""
    return {name: Variable((name,), np.asarray(values), unit, description)}
