"""Figures belong to nobody's window, and a panel can be drawn into a user's axes."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from apesim.archive import Archive, Variable
from apesim.engine.machine import Machine
from apesim.quantities.settings import dumps
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.panels import (
    add_figure_legend,
    add_legend,
    label_axes,
    open_one,
    open_row,
    open_wrapped,
)
from apesim.studies.drawing.spread import spread_out
from apesim.studies.drawing.style import STYLE, colours_of, looks_of
from apesim.studies.optimise.figures import draw_over_speed, optimise_figures

SPEEDS = np.array([600.0, 1000.0])
TORQUES = {"fixed": np.array([20.0, 10.0]), "most_torque": np.array([24.0, 18.0])}


@pytest.fixture
def archive():
    over_runs = {"speed_rpm": SPEEDS}
    for kind, torque in TORQUES.items():
        over_runs |= {f"{kind}_brake_torque_Nm": torque, f"{kind}_specific_air_kg_per_kWh": 900.0 / torque}
        over_runs |= {f"{kind}_energise_deg": -0.02 * SPEEDS, f"{kind}_release_deg": 70.0 - 0.02 * SPEEDS}
        over_runs |= {f"{kind}_valve_open_deg": 0.0 * SPEEDS - 5.0, f"{kind}_valve_close_deg": 0.0 * SPEEDS + 70.0}
    variables = {name: Variable(("run",), values, "1", name) for name, values in over_runs.items()}
    return Archive(dumps(Machine()), {}, variables)


def test_a_panel_is_drawn_into_a_user_s_axes_and_these_are_returned(archive):
    figure, (own, other) = plt.subplots(1, 2)
    assert draw_over_speed(own, archive, "brake_torque_Nm") is own
    lines = {line.get_label(): line.get_ydata() for line in own.lines}
    assert lines["fixed"].tolist() == TORQUES["fixed"].tolist()
    assert lines["for most torque"].tolist() == TORQUES["most_torque"].tolist()
    assert own.get_xlabel() == "speed [r/min]" and not other.lines
    plt.close(figure)


def test_figures_are_written_the_same_each_time_and_open_no_window(archive, tmp_path):
    before, settings = plt.get_fignums(), {name: plt.rcParams[name] for name in STYLE}
    written = [optimise_figures(archive, 101325.0, tmp_path / name) for name in "ab"]
    assert [path.name for path in written[0]] == [
        f"optimum_{name}.{kind}" for name in ("angles", "torque_and_air") for kind in ("png", "pdf")
    ]
    for first, second in zip(*written, strict=True):
        assert first.read_bytes() == second.read_bytes()
    assert plt.get_fignums() == before
    assert {name: plt.rcParams[name] for name in STYLE} == settings


def test_figures_have_the_house_style_whatever_a_user_has_set(archive, tmp_path):
    def make():
        figure, (left, _) = open_row(2)
        draw_over_speed(left, archive, "brake_torque_Nm")
        left.legend()
        return figure

    [plain, _] = write_figures({"plain": make}, tmp_path)
    with plt.rc_context({"lines.linewidth": 5.0, "legend.fontsize": 20.0, "axes.grid": False}):
        [set_otherwise, _] = write_figures({"set_otherwise": make}, tmp_path)
    assert plain.read_bytes() == set_otherwise.read_bytes()


def test_names_of_axes_stand_with_their_units():
    _, axis = open_one()
    label_axes(axis, x=("crank angle", "deg"), y=("solenoid A", ""))
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("crank angle [deg]", "solenoid A")
    label_axes(axis, title="opening")
    assert (axis.get_xlabel(), axis.get_title()) == ("crank angle [deg]", "opening")


@pytest.mark.parametrize(("count", "most", "chosen"), [(1, 3, [0]), (2, 5, [0, 1]), (7, 3, [0, 3, 6])])
def test_some_of_many_runs_have_the_first_and_the_last_among_them(count, most, chosen):
    assert spread_out(count, most).tolist() == chosen
    assert len(np.unique(colours_of(count), axis=0)) == count


def test_a_legend_stands_where_no_line_runs():
    _, panel = open_one((4.0, 3.0))
    x = np.linspace(0.0, 20.0, 400)
    for phase in range(5):
        panel.plot(x, np.sin(x + phase), label=f"{phase}")
    add_legend(panel)
    panel.figure.draw_without_rendering()
    box = panel.get_legend().get_window_extent()
    lines = [panel.transData.transform(np.column_stack(line.get_data())) for line in panel.lines]
    assert not any(box.count_contains(points) for points in lines)


def test_a_legend_of_a_figure_is_as_wide_as_the_figure_at_most():
    figure, panel = open_one((4.0, 3.0))
    handles = [panel.plot([0.0], [0.0], label=f"with an effect of a long name, {number}")[0] for number in range(6)]
    add_figure_legend(figure, handles, side="upper")
    figure.draw_without_rendering()
    box = figure.legends[0].get_window_extent()
    assert box.x0 >= 0.0 and box.x1 <= figure.bbox.width


def test_more_panels_than_three_are_wrapped():
    figure, panels = open_wrapped(7, (3.0, 2.5))
    assert len(panels) == len(figure.axes) == 7
    assert figure.get_size_inches().tolist() == [9.0, 7.5]


def test_lines_that_colours_distinguish_have_markers_of_their_own():
    from apesim.studies.optimise import figures as optimise
    from apesim.studies.sweep import figures as sweep

    assert len({marker for _, marker, _ in optimise.LOOKS.values()}) == len(optimise.LOOKS)
    assert len(set(sweep.MARKERS.values())) == len(sweep.MARKERS)
    assert len({look["marker"] for look in looks_of(5)}) == 5
