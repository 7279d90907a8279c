"""Export of an FMU: a machine's valve or engine as a file that simulation programs load, without Python."""

import hashlib
import io
import platform
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import apesim
from apesim.archive import write_file
from apesim.engine.machine import Machine
from apesim.quantities import Fault, InputError, quoted
from apesim.quantities.arguments import WithUnit
from apesim.studies.execution.calls import arguments_of, public
from apesim.studies.execution.output import refuse_to_replace
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.fmu.description import describe, identifier_of
from apesim.studies.fmu.engine_model import engine_model
from apesim.studies.fmu.header import header
from apesim.studies.fmu.library import find_compilers, link
from apesim.studies.fmu.model import Model, Variable
from apesim.studies.fmu.page import page
from apesim.studies.fmu.parameters import Parameter, find_orders, find_parameters
from apesim.studies.fmu.step_object import step_objects
from apesim.studies.fmu.valve_model import valve_model
from apesim.studies.run.operating_conditions import SPEED

MODELS = ("valve", "engine")
"""What can be exported."""
START_SPEED = "1000 rpm"
"""Speed of an engine that is not told."""
PROCESSORS = ("x86_64", "amd64")
"""Names of the processors that code is compiled for, and on: what was made ready for another is of no use."""
VERSIONS = (2, 3)
"""Versions of FMI."""
EPOCH = (1980, 1, 1, 0, 0, 0)
"""Time of the files in an FMU, the first that the format knows: the same machine gives the same bytes."""


@dataclass(frozen=True)
class ExportedFmu:
    """FMU that was written.

    Attributes
    ----------
    path : pathlib.Path
        The file.
    model : str
        What it is of: "valve" or "engine".
    fmi : int
        Version of FMI, 2 or 3.
    inputs, outputs : tuple of str
        Names of its inputs and outputs.
    parameters : dict of str to float
        Keys of the machine that an importer may change, with their values in SI.
    fixed : dict of str to float
        Keys that are fixed at export, with their values in SI.
    platforms : tuple of str
        Platforms that it has a library for.
    """

    path: Path
    model: str
    fmi: int
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    parameters: Mapping[str, float]
    fixed: Mapping[str, float]
    platforms: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return it as data, as ``apesim fmu --json`` shows it.

        Returns
        -------
        dict
            The attributes, and the size of the file in bytes.

        Examples
        --------
        >>> fmu = apesim.export_fmu(apesim.Machine(), "valve", "valve.fmu")  # doctest: +SKIP
        >>> fmu.to_dict()["platforms"]  # doctest: +SKIP
        ['linux64']
        """
        return {
            "file": str(self.path),
            "model": self.model,
            "fmi": self.fmi,
            "inputs": list(self.inputs),
            "outputs": list(self.outputs),
            "parameters": dict(self.parameters),
            "fixed": dict(self.fixed),
            "platforms": list(self.platforms),
            "bytes": self.path.stat().st_size,
        }

    def summary(self) -> str:
        """Say what was written, as ``apesim fmu`` does.

        Returns
        -------
        str
            Some lines.

        Examples
        --------
        >>> fmu = apesim.export_fmu(apesim.Machine(), "valve", "valve.fmu")  # doctest: +SKIP
        >>> fmu.summary().splitlines()[1]  # doctest: +SKIP
        'inputs: command, supply_pressure_Pa, supply_temperature_K'
        """
        size = self.path.stat().st_size / 1e3
        lists = {
            "inputs": self.inputs,
            "outputs": self.outputs,
            "parameters": self.parameters,
            "fixed at export": (*self.fixed, "curves, choices, effects"),
        }
        head = f"{self.path}: written, FMI {self.fmi}, {size:.0f} kB, for {' and '.join(self.platforms)}"
        return "\n".join([head, *(f"{what}: {', '.join(names)}" for what, names in lists.items())])


@public
def export_fmu(
    machine: Machine,
    model: str,
    out: str | PathLike[str],
    *,
    fmi: int = 2,
    speed: WithUnit = START_SPEED,
    free: bool = False,
    overwrite: bool = False,
) -> ExportedFmu:
    """Export a machine's valve or engine as an FMU for co-simulation, which other programs load without Python.

    The first export of a kind compiles for half a minute. A C compiler has to be there: that of the system, or
    the package ``ziglang``, which compiles for Windows, too.

    Parameters
    ----------
    machine : Machine
        Machine; its numbers are the parameters of the FMU.
    model : {"valve", "engine"}
        What to export: the valve on its bench, or the whole engine.
    out : path
        File to write, ``.fmu``.
    fmi : {2, 3}
        Version of the standard FMI.
    speed : str or (float, str)
        Speed of an engine, in whose periodic state its FMU begins.
    free : bool
        An engine's shaft is free, and its load is an input; else its speed is.
    overwrite : bool
        Replace a file that is there.

    Returns
    -------
    ExportedFmu
        What was written: names of inputs and outputs, parameters, platforms.

    Raises
    ------
    InputError
        An argument is none of these, there is no C compiler, or the processor is no x86-64.
    NotConverged
        The engine has no periodic state at that speed.
    ArchiveError
        The file exists, or cannot be written.

    Examples
    --------
    >>> import apesim
    >>> fmu = apesim.export_fmu(apesim.Machine(), "valve", "valve.fmu")  # doctest: +SKIP
    >>> fmu.parameters["valve.stroke"]  # doctest: +SKIP
    0.009
    """
    arguments, machine = arguments_of("export_fmu", machine)
    omega = arguments.quantity("speed", speed, SPEED)
    if model not in MODELS:
        arguments.fault("model", f"{quoted(model)} is no model", f"write {' or '.join(MODELS)}")
    if fmi not in VERSIONS:
        arguments.fault("fmi", f"{quoted(fmi)} is no version of FMI", "write 2 or 3")
    arguments.refuse()
    refuse_to_replace(out, overwrite=overwrite)
    if platform.machine().lower() not in PROCESSORS:
        raise InputError([Fault("processor", "", "is no x86-64", "export the FMU on one that is")])
    compilers = find_compilers()
    if not compilers:
        raise InputError([Fault("C compiler", "", "is not there", "install gcc, or the package ziglang")])

    # What the machine is, as numbers; which of them follow which keys; and the compiled step.
    made = valve_model(machine) if model == "valve" else _engine(machine, omega, free)
    example = made.numbers_of(machine)
    parameters, fixed = find_parameters(machine, made.numbers_of, made.given, made.held)
    orders = find_orders(example, parameters)
    objects = step_objects(machine, made)

    # The token is of all that is within: a library takes no other's description, and no other's state.
    version = str(apesim.__version__)
    untold = header(made, example, parameters, fixed, orders, "")
    token = _token(untold, version, str(fmi), *map(repr, sorted(objects.items())))
    told = header(made, example, parameters, fixed, orders, token)
    name, contents = identifier_of(made), dict[str, bytes]()
    contents["modelDescription.xml"] = describe(made, parameters, fixed, fmi, token, version)
    folders = {each: each.fmi2 if fmi == 2 else each.fmi3 for each in compilers}
    for each, compiler in compilers.items():
        library = link(compiler, objects[each.name], told, fmi)
        contents[f"binaries/{folders[each]}/{name}{each.ending}"] = library
    text = machine.to_toml()
    contents["documentation/index.html"] = page(made, parameters, fixed, text, version).encode()
    contents["resources/machine.toml"] = text.encode()
    write_file(out, _zipped(contents))
    return ExportedFmu(
        Path(out),
        model,
        fmi,
        _names(made.inputs),
        _names(made.outputs),
        _values(parameters),
        _values(fixed),
        tuple(folders.values()),
    )


def _engine(machine: Machine, speed: float, free: bool) -> Model:
    """Make the model of an engine; what settles it compiles in a thread of its own."""
    return call_in_thread(engine_model, machine, speed, free).result()


def _token(*texts: str) -> str:
    """Name of an FMU by what is in it, in the form of a GUID."""
    digits = hashlib.sha256("\n".join(texts).encode()).hexdigest()[:32]
    return "{" + "-".join((digits[:8], digits[8:12], digits[12:16], digits[16:20], digits[20:])) + "}"


def _zipped(contents: Mapping[str, bytes]) -> bytes:
    """Files as one, by their paths."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in contents.items():
            info = zipfile.ZipInfo(path, EPOCH)
            info.external_attr = (0o755 if path.startswith("binaries/") else 0o644) << 16
            archive.writestr(info, content, zipfile.ZIP_DEFLATED)
    return made.getvalue()


def _names(variables: Sequence[Variable]) -> tuple[str, ...]:
    """Names of variables."""
    return tuple(variable.name for variable in variables)


def _values(parameters: Iterable[Parameter]) -> dict[str, float]:
    """Values of parameters by their keys."""
    return {each.key: each.value for each in parameters}
