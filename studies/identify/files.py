"""Files of a fit: its numbers as JSON, the fitted machine with where it comes from, and figures."""

import json
from importlib.metadata import version
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from apesim.engine.machine import Machine
from apesim.quantities import Quantity
from apesim.quantities.settings import dumps
from apesim.studies.execution.output import make_folder, write_file
from apesim.studies.measured.lineage import find_lineage

if TYPE_CHECKING:
    from apesim.studies.identify.estimate import Fit


def write_fit(fit: "Fit", folder: str | PathLike[str], *, overwrite: bool = False) -> list[Path]:
    """Write ``fit.json``, ``machine.toml`` and the figures of a fit to a folder, which is made where there is none.

    Raises ArchiveError where the folder or a file cannot be written, or where the folder holds something and
    `overwrite` is not set.
    """
    from apesim.studies.terminal.console import plain

    assert fit.fitted_machine is not None and fit.measured is not None
    folder = Path(folder)
    lineage = find_lineage(fit.measured, fit.parent_text, fit.fitted_machine)
    make_folder(folder, overwrite)
    data = plain(fit.to_dict() | {"lineage": lineage})
    paths = [folder / "fit.json", folder / "machine.toml"]
    write_file(paths[0], json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    write_file(paths[1], _machine_text(fit, lineage, folder))
    from apesim.studies.identify.figures import fit_figures

    return paths + fit_figures(fit, folder)


def _machine_text(fit: "Fit", lineage: dict[str, str], folder: Path) -> str:
    """The fitted machine as TOML, with what it comes from in comments; each fitted value has its interval above it."""
    machine = fit.fitted_machine
    assert machine is not None
    lines = [f"apesim {version('apesim')}, valve fit, method {fit.method}"]
    notes = {}
    for key, value in fit.parameters.items():
        declared, ends = fit.declared[key], fit.interval_95[key]
        low, high = (_shown(declared, end, machine) for end in ends) if ends else ("", "")
        interval = f"95 % from {low} to {high}" if ends else "without an interval"
        notes[key] = f"fitted; {interval}"
        lines.append(f"{key} = {_shown(declared, value, machine)}, {interval}")
    if not fit.converged:
        lines.append("the fit has not converged: these values are not to be believed")
    lines += [f"{run.run} refuses this machine, see fit.json" for run in fit.gates if run.contradicted]
    lines += [f"{name.replace('_', ' ')} {digest}" for name, digest in lineage.items()]
    return "".join(f"# {line}\n" for line in lines) + "\n" + dumps(machine, folder, notes)


def _shown(declared: Quantity, value: float, machine: Machine) -> str:
    """A value with its unit in six digits: more would be none of the data's."""
    return declared.render(float(f"{value:.6g}"), machine.ambient.pressure)
