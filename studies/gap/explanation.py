"""The result of the missing-effect workflow."""

import html
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from apesim.archive import remove_file, write_file
from apesim.quantities import Fault, InputError
from apesim.quantities.settings import dumps
from apesim.studies.drawing.axes import axes_for, in_house_style
from apesim.studies.estimation.model import Model
from apesim.studies.execution.output import make_folder
from apesim.studies.gap.decide.consistency import Inconsistency
from apesim.studies.gap.decide.held_out import HeldOut
from apesim.studies.gap.decide.odd_files import OddChannel
from apesim.studies.gap.decide.operating_points import label_point
from apesim.studies.gap.decide.verdict import Decision
from apesim.studies.gap.reasons import Verdict
from apesim.studies.gap.report.extended_machine import extend_machine, write_sensors
from apesim.studies.gap.report.petab_select import export_model_space
from apesim.studies.gap.report.verdict_json import describe
from apesim.studies.gap.search.gap_test import GapTest
from apesim.studies.gap.search.localisation import Cell
from apesim.studies.gap.search.model_selection import Foreseen, PricedModel
from apesim.studies.gap.search.score_test import Score, Sensitivity
from apesim.studies.gap.tables.balance import Balance
from apesim.studies.gap.tables.latent import find_branches
from apesim.studies.gap.tables.tabulate import Tabulated
from apesim.studies.measured import Measured
from apesim.studies.measured.lineage import find_lineage

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from apesim.studies.gap.report.comparison import ComparedSignal

MAX_SHOWN = 8
"""Scores that the HTML table shows, as many as the command does."""


@dataclass(frozen=True, eq=False, repr=False)
class Explanation:
    """What is missing between a machine and measured data, and how it was found.

    Attributes
    ----------
    verdict : Verdict
    reason : str
    sentence : str
        The verdict in words.
    effects : list of dict
        What is missing: ``name``, ``parameter``, ``value``, ``unit``, ``interval_95`` and more.
    sure : list of dict
        What is missing though the gap is ambiguous, as all explanations that are left contain it.
    probability : float or None
        How often such a verdict was right on sealed cases; None where these do not tell.
    inclusion : dict
        How probable each effect is to be part of what is missing, by its name; those that the data do not distinguish
        are one, with "or" between their names.
    alternatives : list of dict
        Explanations that the data do not distinguish from the best one.
    gap, held_out : dict
        Root mean squares over the noise, ``before``, ``after`` and ``noise_floor``, on the fitted runs and on the check
        runs; `held_out` is None where there are no check runs.
    localised : dict
        Where the gap lives: ``signal``, ``phase``, ``balance``, ``shares``.
    detection_limits : dict
        By effect the size from which these data show it.
    next_test : dict
        The experiment that would show more; its ``text`` and its data.
    warnings : list of str
        The most important first.
    measured : Measured
    calibrated : Model
        The machine with its uncertain numbers fitted under their priors.
    sensitivities : list of Sensitivity
        What each candidate would do to the data.
    scores : list of Score
        The best first.
    gap_test : GapTest
    solver_error : float
        The simulator's own error over the noise of a sample.
    tolerance : float
        Size of a gap, over the noise, that does not matter.
    cells : list of Cell
        Signals and phases with their shares of the gap.
    decision : Decision
        The verdict with what it rests on.
    fits : sequence of PricedModel
        All models that were fitted, before runs held out were looked at.
    ranked : sequence of PricedModel
        The same with what the gate runs say, the best first.
    foreseen : sequence of Foreseen
        Sets that were not fitted, as a linear model foresees them, the best first.
    judged : HeldOut or None
        The best of them on the gate runs, with operating points left out one at a time, or both together where gates
        hardly show it. What it is held against may be the machine with the numbers of the best one, see
        `apesim.studies.gap.decide.held_out.find_baseline`.
    left_p_value : float
        Chance of noise alone to leave as much as the best of them does, or as the calibrated machine where none was
        fitted.
    gap_size : float
        Size of the gap where it is largest, over the noise.
    balances : sequence of Balance
        What each table takes of the gap, the best first; none where there is no gap.
    tabulated : Tabulated or None
        The table that is added where the library is refused.
    checked : HeldOut or None
        `best` on the check runs.
    consistency : sequence of Inconsistency
        Where each operating point alone leads the parameters of `best`.
    odd : sequence of OddChannel
        Channels of single files that are explained worse than noise allows, where nothing is said to be missing.
    rest : Explanation or None
        What the other files say, where the record of one is wrong.
    simulations : int
    parent_text : str or None
        The machine file that the search began with; the machine's own text if None.
    wall_time_s : float
        Computing time [s].
    """

    measured: Measured
    calibrated: Model
    sensitivities: list[Sensitivity]
    scores: list[Score]
    gap_test: GapTest
    solver_error: float
    tolerance: float
    cells: list[Cell]
    decision: Decision
    warnings: list[str]
    fits: Sequence[PricedModel] = ()
    ranked: Sequence[PricedModel] = ()
    foreseen: Sequence[Foreseen] = ()
    judged: HeldOut | None = None
    left_p_value: float = 1.0
    gap_size: float = 0.0
    balances: Sequence[Balance] = ()
    tabulated: Tabulated | None = None
    checked: HeldOut | None = None
    consistency: Sequence[Inconsistency] = ()
    odd: Sequence[OddChannel] = ()
    rest: "Explanation | None" = None
    simulations: int = 0
    next_test: dict[str, Any] = field(default_factory=dict)
    parent_text: str | None = None
    wall_time_s: float = 0.0

    @property
    def noise(self) -> dict[str, Any]:
        """The noise of each sensor, at each sampling interval."""
        return self.calibrated.residuals.noise

    @property
    def best(self) -> Model:
        """The table that was added, else what explains best; the calibrated machine where nothing does."""
        if self.tabulated:
            return self.tabulated.model
        return self.decision.best.model if self.decision.best else self.calibrated

    @property
    def verdict(self) -> Verdict:
        """The verdict."""
        return self.decision.verdict

    @property
    def reason(self) -> str:
        """Why the verdict is given."""
        return str(self.decision.reason)

    @cached_property
    def _described(self) -> dict[str, Any]:
        from apesim.studies.terminal.console import plain

        machine = self.calibrated.residuals.machine
        parent = dumps(machine) if self.parent_text is None else self.parent_text
        data = plain(describe(self) | {"next_test": self.next_test})
        return data | {"lineage": find_lineage(self.measured, parent, machine)}

    @property
    def sentence(self) -> str:
        """The verdict in words."""
        return self._described["sentence"]

    @property
    def effects(self) -> list[dict[str, Any]]:
        """What is missing, with values and 95 % intervals; [] where nothing is named."""
        return self._described["effects"]

    @property
    def sure(self) -> list[dict[str, Any]]:
        """What is missing, or is wrong, whatever else explains an ambiguous gap; [] where nothing is sure.

        Rows as `effects` has them, with the values of the best explanation; ``class`` names what the data do not
        distinguish from it.
        """
        return self._described["sure"]

    @property
    def probability(self) -> float | None:
        """How often such a verdict was right on sealed cases; None where these do not tell."""
        return self._described["probability"]

    @property
    def inclusion(self) -> dict[str, float | None]:
        """How probable each effect is to be part of what is missing; None where sealed cases do not tell."""
        return self._described["inclusion"]

    @property
    def alternatives(self) -> list[dict[str, Any]]:
        """Explanations that the data do not distinguish from the best one."""
        return self._described["alternatives"]

    @property
    def gap(self) -> dict[str, float]:
        """The gap on the fitted runs, root mean squares over the noise."""
        return self._described["gap"]

    @property
    def held_out(self) -> dict[str, float] | None:
        """The gap on the check runs, root mean squares over the noise; None where there are none."""
        return self._described["held_out"]

    @property
    def localised(self) -> dict[str, Any]:
        """Signal, phase of the stroke or cycle, and balance that the gap lives in."""
        return self._described["localised"]

    @property
    def detection_limits(self) -> dict[str, dict[str, Any]]:
        """Sizes from which these data show the effects, by effect."""
        return self._described["detection_limits"]

    def to_dict(self) -> dict[str, Any]:
        """The content of ``verdict.json``.

        Returns
        -------
        dict

        Examples
        --------
        >>> from apesim.studies.gap.example_bench import explain_example
        >>> explain_example().to_dict()["verdict"]
        'NAMED'
        """
        return json.loads(json.dumps(self._described)) | {"wall_time_s": self.wall_time_s}

    def write(
        self,
        folder: str | PathLike[str],
        *,
        overwrite: bool = False,
        progress: Callable[[str, int, int], object] | None = None,
    ) -> dict[str, Any]:
        """Write ``verdict.json``, ``machine.toml``, ``report.html``, figures and the searched models to a folder.

        What was fitted of the sensors goes to ``sensors.toml``, where there is any.

        Parameters
        ----------
        folder : path
            Is made where it does not exist.
        overwrite : bool
            Whether to write into a folder that holds something.
        progress : callable, optional
            Called with the name of the stage, what is done of it and what there is to do.

        Returns
        -------
        dict
            The content of ``verdict.json``; its ``wall_time_s`` counts the writing, too.

        Raises
        ------
        ArchiveError
            The folder or a file cannot be written, or the folder is not empty.

        Examples
        --------
        >>> from tempfile import TemporaryDirectory
        >>> from apesim.studies.gap.example_bench import explain_example
        >>> with TemporaryDirectory() as folder:
        ...     written = explain_example().write(folder)
        ...     sorted(path.name for path in Path(folder).iterdir())
        ['figures', 'machine.toml', 'petab_select', 'report.html', 'sensors.toml', 'verdict.json']
        """
        from apesim.studies.gap.figures import draw_gap
        from apesim.studies.gap.report.comparison import compare_signals
        from apesim.studies.gap.report.engine_curve import find_curves, is_speed_curve
        from apesim.studies.gap.report.html import compare_candidates, describe_added, render_page

        start, data, folder = time.perf_counter(), self.to_dict(), Path(folder)
        make_folder(folder, overwrite)
        if progress:
            progress("writing the report", 0, 1)

        # The machine and its sensors. An earlier verdict's readings do not stay beside a machine that they are not of.
        write_file(folder / "machine.toml", extend_machine(self, data, folder))
        if sensors := write_sensors(self, data):
            write_file(folder / "sensors.toml", sensors)
        else:
            remove_file(folder / "sensors.toml")

        # Figures and page share one comparison, as every signal is simulated for it.
        compared = compare_signals(self)
        for name in ("figures", "petab_select"):
            make_folder(folder / name, overwrite=True)
        latent = find_branches(self.tabulated.model) if self.tabulated else ()
        ambient = self.calibrated.residuals.machine.ambient.pressure
        curves = find_curves(self, compared) if is_speed_curve(self.measured) else ()
        figures = draw_gap(
            compared, compare_candidates(self), describe_added(self), ambient, folder / "figures", latent, curves
        )
        write_file(folder / "report.html", render_page(self, data, compared, figures, curves))

        # The models that were searched, for other programs.
        for name, text in export_model_space(self).items():
            write_file(folder / "petab_select" / name, text)

        # The verdict last, as its computing time counts the writing of all else.
        data["wall_time_s"] += time.perf_counter() - start
        write_file(folder / "verdict.json", json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
        return data

    @in_house_style
    def plot(self, ax: "Axes | None" = None, sensor: str | None = None) -> "Axes":
        """Draw what is left of one signal over the noise, before and after what is missing was added.

        It is the trace that the calibrated machine misses most, of a run that was never fitted where there are such.
        A mean of an engine, such as its torque, is drawn over the speed, with the models beside what was measured.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; those of a new figure if left out.
        sensor : str, optional
            Name of the signal, e.g. "lift"; the one that the calibrated machine misses most if left out, a mean only
            where there are no traces.

        Returns
        -------
        matplotlib.axes.Axes
            Axes that were drawn on.

        Raises
        ------
        InputError
            There is no such signal.

        Examples
        --------
        >>> from apesim.studies.gap.example_bench import explain_example
        >>> axes = explain_example().plot()
        >>> axes.get_title(), axes.get_ylabel()
        ('0.60 MPa gauge, 40 ms, never used', 'model less measured lift [sigmas of the noise]')
        """
        from apesim.studies.drawing.panels import add_legend
        from apesim.studies.gap.figures.overlays import draw_left
        from apesim.studies.gap.figures.style import WORDS
        from apesim.studies.gap.report.comparison import compare_signals, find_display, select_worst
        from apesim.studies.gap.report.html import describe_added

        compared = compare_signals(self)
        asked = [signal for signal in compared if sensor in (None, signal.block.sensor)]
        chosen = select_worst(asked, 1)
        if asked and not chosen:
            return self._plot_curve(ax, asked)
        if not chosen:
            known = " or ".join(dict.fromkeys(one.block.sensor for one in compared)) or "a run with a trace"
            raise InputError(
                [Fault("plot()", "sensor", f"there is no trace of {sensor or 'any signal'}", f"give {known}")]
            )
        [signal] = chosen
        ax = draw_left(axes_for(ax), signal, describe_added(self))
        ambient = self.calibrated.residuals.machine.ambient.pressure
        ax.set_ylabel(f"model less measured {find_display(signal.block).name} [sigmas of the noise]")
        ax.set_title(f"{label_point(signal.block.run, ambient)}, {WORDS[signal.role]}")
        add_legend(ax)
        return ax

    def _plot_curve(self, ax: "Axes | None", means: "list[ComparedSignal]") -> "Axes":
        """Draw the mean of an engine over the speed that the calibrated machine misses most, with the models."""
        from apesim.studies.drawing.panels import add_legend
        from apesim.studies.gap.figures.curve import draw_curves, list_handles, mark_supplies
        from apesim.studies.gap.report.comparison import find_rms
        from apesim.studies.gap.report.engine_curve import find_curves
        from apesim.studies.gap.report.html import describe_added

        of_sensor: dict[str, list[ComparedSignal]] = {}
        for signal in means:
            of_sensor.setdefault(signal.block.sensor, []).append(signal)
        worst = max(of_sensor.values(), key=lambda own: find_rms(signal.residuals_before for signal in own))
        curves = find_curves(self, worst)
        ax = draw_curves(axes_for(ax), curves, mark_supplies(curves))
        add_legend(ax, handles=list_handles(curves, describe_added(self)))
        return ax

    def __repr__(self) -> str:
        lines = [f"Explanation: {self.verdict}", f"  {self.sentence}", f"  because {self.reason}"]
        lines.append(f"  gap over noise on the fitted runs: {self._format_change(self.gap)}")
        if self.held_out:
            lines.append(f"  on runs opened once: {self._format_change(self.held_out)}")
        if self.next_test:
            lines.append(f"  next test: {self.next_test['text']}")
        if self.warnings:
            lines.append(f"  {len(self.warnings)} warnings, see .warnings")
        return "\n".join(lines)

    def _format_change(self, gap: dict[str, float]) -> str:
        """A gap before and after something was added; one number where nothing was."""
        before = f"{gap['before']:.3g}"
        return before if self.best is self.calibrated else f"{before} before, {gap['after']:.3g} after"

    def _repr_html_(self) -> str:
        rows = "".join(
            f'<tr><td>{html.escape(score.name)}</td><td style="text-align:right">{score.n_sigma:.1f}</td></tr>'
            for score in self.scores[:MAX_SHOWN]
        )
        lines = "".join(f"<div>{html.escape(line.strip())}</div>" for line in repr(self).splitlines()[1:])
        head = "<tr><th>effect</th><th>score [standard deviations]</th></tr>"
        return f"<b>{self.verdict}</b>{lines}<table>{head}{rows}</table>"
