"""Parameters of a machine from measured lift, as a result."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isnan, nan
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from apesim.engine.machine import Machine
from apesim.quantities import Choice, Fault, InputError, Quantity
from apesim.results import Result, Scalar
from apesim.studies.drawing.axes import axes_for, in_house_style
from apesim.studies.execution.calls import public
from apesim.studies.identify.fit import Identified, identify
from apesim.studies.identify.free import LEAST_SQUARES, METHODS, free_parameters, si_unit
from apesim.studies.identify.gate import Judgement, judge
from apesim.studies.measured import CHECK, GATE, VALVE, Measured
from apesim.studies.measured.arguments import Tell, open_measured
from apesim.studies.measured.plausibility import refuse_faults

if TYPE_CHECKING:
    from matplotlib.axes import Axes

METHOD = Choice(METHODS, "a call")


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Result):
    """Parameters that were identified from measured data, in SI by their keys of the machine file.

    ``fit["valve.viscous_friction"]`` is a value; what the warnings say belongs to it.

    Attributes
    ----------
    parameters : mapping of str to float
    interval_95 : mapping of str to (float, float) or None
        Low and high end; None from a method that gives no interval.
    correlation : (p, p) ndarray or None
        Of the estimates, in the order of the parameters.
    objective : float
        Eq. 11 of the EPV paper (doi 10.1631/jzus.A0820373) over all fitted samples of lift [m]; NaN without any.
    noise : mapping of str to (float, float)
        Standard deviation [SI] and colour of what is left at the optimum, by sensor.
    gates, checks : sequence of Judgement
        Runs of these roles, which were not fitted.
    evaluations : int
        Simulations of one run each.
    fitted_machine : Machine
        The machine with the parameters.
    declared : mapping of str to Quantity
        How the machine file declares each parameter.
    method : str
    wall_time_s : float
        Computing time of the call [s].
    measured : Measured
        The runs.
    identified : Identified
        What the search found, from which runs are simulated.
    parent_text : str
        The machine file that the search began with.
    """

    title: ClassVar[str] = "parameters from measured data"

    interval_95: Mapping[str, tuple[float, float] | None] = field(default_factory=dict)
    correlation: np.ndarray | None = None
    objective: float = nan
    noise: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    gates: Sequence[Judgement] = ()
    checks: Sequence[Judgement] = ()
    evaluations: int = 0
    fitted_machine: Machine | None = None
    declared: Mapping[str, Quantity] = field(default_factory=dict)
    method: str = LEAST_SQUARES
    wall_time_s: float = 0.0
    measured: Measured | None = None
    identified: Identified | None = None
    parent_text: str = ""

    @property
    def parameters(self) -> dict[str, float]:
        """Values of the parameters in SI, by key."""
        return {name: scalar.value for name, scalar in self.scalars.items()}

    @property
    def is_refused(self) -> bool:
        """Whether a gate run contradicts the fitted machine beyond noise."""
        return any(one.contradicted for one in self.gates)

    @in_house_style
    def plot(self, ax: "Axes | None" = None, run: str | None = None) -> "Axes":
        """Draw a measured run over the fitted machine: its lift, or else its first channel.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; those of a new figure if left out.
        run : str, optional
            Data file of the run; the first that was fitted if left out.

        Returns
        -------
        matplotlib.axes.Axes
            Axes that were drawn on.

        Raises
        ------
        InputError
            There is no such run.

        Examples
        --------
        >>> import apesim
        >>> from apesim.studies.gap.example_bench import read_example
        >>> axes = apesim.fit(read_example(), ["valve.viscous_friction"]).plot()
        >>> axes.get_xlabel(), axes.get_ylabel()
        ('time after the command [ms]', 'lift [mm]')
        """
        from apesim.studies.drawing.panels import add_legend
        from apesim.studies.identify.figures import draw_run, list_drawable

        runs = list_drawable(self)
        chosen = [one for one in runs if run in (None, one.data)]
        if not chosen:
            known = ", ".join(one.data for one in runs)
            raise InputError(
                [Fault("plot()", "run", f"there is no trace of {run or 'any run'}", f"give one of {known}")]
            )
        ax = draw_run(axes_for(ax), self, chosen[0])
        add_legend(ax)
        return ax

    def write(self, folder: str | PathLike[str], *, overwrite: bool = False) -> list[Path]:
        """Write ``fit.json``, the fitted machine as ``machine.toml``, and figures of the runs over it to a folder.

        Parameters
        ----------
        folder : path
            Is made where it does not exist.
        overwrite : bool
            Whether to write into a folder that holds something.

        Returns
        -------
        list of Path

        Raises
        ------
        ArchiveError
            The folder or a file cannot be written, or the folder is not empty.

        Examples
        --------
        >>> from tempfile import TemporaryDirectory
        >>> import apesim
        >>> from apesim.studies.gap.example_bench import write_example
        >>> with TemporaryDirectory() as folder:
        ...     measured = Path(folder, "measured")
        ...     measured.mkdir()
        ...     write_example(measured)
        ...     fitted = apesim.fit(f"{folder}/measured", ["valve.viscous_friction"])
        ...     _ = fitted.write(f"{folder}/fitted")
        ...     again = apesim.Machine.load(f"{folder}/fitted/machine.toml")
        >>> again.valve.viscous_friction == fitted["valve.viscous_friction"]
        True
        """
        from apesim.studies.identify.files import write_fit

        return write_fit(self, folder, overwrite=overwrite)

    def to_dict(self) -> dict[str, Any]:
        """Return the content of ``apesim valve fit --json``.

        Returns
        -------
        dict

        Examples
        --------
        >>> Fit({"valve.stroke": Scalar(0.009, "m")}, evaluations=12).to_dict()["parameters"]
        {'valve.stroke': 0.009}
        """
        return {
            "method": self.method,
            "parameters": self.parameters,
            "interval_95": dict(self.interval_95),
            "units": {key: si_unit(declared) for key, declared in self.declared.items()},
            "evaluations": self.evaluations,
            "objective": self.objective,
            "objective_unit": "m",
            "correlation": None if self.correlation is None else self.correlation.tolist(),
            "noise": {s: {"deviation": d, "colour": c} for s, (d, c) in self.noise.items()},
            "gates": [one._asdict() for one in self.gates],
            "checks": [one._asdict() for one in self.checks],
            "refused": self.is_refused,
            "wall_time_s": self.wall_time_s,
            "warnings": list(self.warnings),
        }


@public
def fit(
    measured: Measured | str | PathLike[str],
    free: Sequence[str],
    *,
    machine: Machine | None = None,
    method: str = LEAST_SQUARES,
    progress: Tell | None = None,
) -> Fit:
    """Identify parameters of a machine from measured lift and chamber pressures of the valve.

    Only runs of the role "fit" are fitted. Those of the role "gate" judge the fitted machine, those of the role "check"
    are only reported.

    Parameters
    ----------
    measured : Measured or path
        Measured data of a valve's bench, see `read_measured`, or their folder.
    free : sequence of str
        Keys of the machine file, each alone or with bounds: ``"valve.viscous_friction=100 N s/m:120 N s/m"``.
    machine : Machine, optional
        Where the search starts; the default machine if left out.
    method : {"least-squares", "ga"}
        The genetic algorithm of the EPV paper (doi 10.1631/jzus.A0820373), Table 2, is slower and gives no intervals.
    progress : callable, optional
        Called with the name of the stage, the number of simulations and None, as their number is not known before.

    Returns
    -------
    Fit

    Raises
    ------
    InputError
        An argument is wrong, the data cannot be what they are said to be, or a parameter changes nothing in the runs.

    Examples
    --------
    Lift of two runs, of a folder that holds a gate and a check, too:

    >>> import tempfile
    >>> from pathlib import Path
    >>> import apesim
    >>> from apesim.studies.gap.example_bench import write_example
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_example(Path(folder))
    ...     fitted = apesim.fit(folder, ["valve.viscous_friction"])
    >>> low, high = fitted.interval_95["valve.viscous_friction"]
    >>> low < fitted["valve.viscous_friction"] < high, [gate.run for gate in fitted.gates]
    (True, ['p50.csv'])
    """
    machine = Machine() if machine is None else machine
    faults = [] if method in METHODS else [("method", f"{method!r} is none", f"write {' or '.join(METHODS)}")]
    machine, measured, _ = open_measured("fit", machine, measured, bench=VALVE, faults=faults)
    released = free_parameters(machine, free, method, ("fit()", "free"))

    # The search. What a free parameter would explain of the data is a warning here, and refuses nothing.
    start = time.perf_counter()
    doubts = refuse_faults(machine, measured, [one.key for one in released])
    report = (lambda done, total: progress("simulations", done, total)) if progress else None
    found = identify(machine, measured, released, method, report)

    # The runs of other roles, by the fitted machine: they were kept from the fit to judge it.
    gates, checks = (judge(found, measured, released, measured.of(role)) for role in (GATE, CHECK))
    wall_time_s = time.perf_counter() - start

    # A gate that judges nothing has to be named, else it would count as passed.
    silent = [one.run for one in gates if isnan(one.residual_over_noise)]
    warnings = [f"{run}: a gate without lift or chamber pressures judges nothing" for run in silent]
    return Fit(
        scalars={
            one.key: Scalar(found.parameters[one.key], si_unit(one.declaration).replace("-", "1"), one.key)
            for one in released
        },
        warnings=(*doubts, *found.warnings, *warnings),
        converged=found.converged,
        machine=found.machine.to_toml(),
        interval_95=found.interval_95,
        correlation=found.correlation,
        objective=found.objective,
        noise={sensor: (known[0.0].deviation, known[0.0].colour) for sensor, known in found.noise.items()},
        gates=gates,
        checks=checks,
        evaluations=found.evaluations,
        fitted_machine=found.machine,
        declared={one.key: one.declaration for one in released},
        method=method,
        wall_time_s=wall_time_s,
        measured=measured,
        identified=found,
        parent_text=machine.to_toml(),
    )
