"""The picture of a machine is to scale, whatever its size."""

import itertools
from math import pi

import numpy as np
import pytest

from apesim import Machine, design_machine
from apesim.studies.drawing.machine import machine_figure
from apesim.studies.drawing.shapes import valve_shape

SIZES = [
    {"bore": "20 mm", "stroke": "20 mm", "rated_speed": "3000 rpm"},
    {},
    {"bore": "150 mm", "stroke": "150 mm", "rated_speed": "600 rpm"},
    {"piston_diameter": "6 mm", "valve_stroke": "3 mm"},
    {"bore": "150 mm", "stroke": "80 mm", "piston_diameter": "60 mm", "valve_stroke": "3 mm"},
]


def texts_of(ax):
    return [text for text in ax.texts if text.get_text().strip()]


@pytest.mark.parametrize("answers", SIZES, ids=str)
def test_dimensions_are_labelled_and_none_overlap(answers):
    machine = design_machine(**answers).machine
    figure = machine_figure(machine)
    figure.draw_without_rendering()
    engine, valve = figure.axes
    shown = " ".join(text.get_text() for text in engine.texts)
    for length in (machine.engine.bore, machine.engine.stroke, machine.engine.rod_length):
        assert f"{1e3 * length:.3g}" in shown
    assert f"lap {1e3 * machine.groove.lap:.3g}" in " ".join(text.get_text() for text in valve.texts)
    for ax in figure.axes:
        boxes = [(text, text.get_window_extent()) for text in texts_of(ax)]
        for (one, first), (other, second) in itertools.combinations(boxes, 2):
            assert not first.overlaps(second), (one.get_text(), other.get_text())
        frame = figure.bbox
        assert all(frame.contains(box.x0, box.y0) and frame.contains(box.x1, box.y1) for _, box in boxes)


@pytest.mark.parametrize("answers", SIZES, ids=str)
def test_the_piston_is_drawn_as_wide_as_the_bore_and_as_far_down_as_the_crank_has_it(answers):
    from apesim.engine.kinematics import crank_of, cylinder_volume, piston_face

    machine = design_machine(**answers).machine
    ax = machine_figure(machine).axes[0]
    charge = next(p for p in ax.patches if np.isclose(p.get_zorder(), 1.5))
    volume = cylinder_volume(crank_of(machine.engine), pi / 3)[0]
    assert charge.get_width() == pytest.approx(1e3 * machine.engine.bore)
    assert charge.get_height() == pytest.approx(1e3 * volume / piston_face(machine.engine))
    assert ax.get_aspect() == 1.0


def test_the_shape_of_the_valve_is_its_volumes():
    shape, valve = valve_shape(Machine()), Machine().valve
    assert shape.clearance * 0.25 * pi * shape.diameter**2 == pytest.approx(1e9 * valve.clearance_volume)
    assert shape.height == pytest.approx(2 * shape.clearance + shape.length + 9.0)
    assert shape.port - (shape.clearance + shape.land + shape.groove) == pytest.approx(1.0)


@pytest.mark.parametrize("intake", ["cam", "ideal"])
def test_another_intake_is_drawn_without_the_valve(intake):
    figure = machine_figure(Machine().with_(engine_intake=intake, engine_receiver_volume="inf"))
    assert len(figure.axes) == 1
    shown = " ".join(text.get_text() for text in figure.axes[0].texts)
    assert intake in shown and "endless" in shown
