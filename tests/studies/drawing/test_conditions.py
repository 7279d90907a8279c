import matplotlib.pyplot as plt
import pytest

from apesim.engine.machine import Machine
from apesim.quantities.settings import dumps, load
from apesim.studies.drawing.conditions import CONTROL_AIR, SUPPLY, VALVE_SECTIONS, conditions_of
from apesim.studies.drawing.files import save
from apesim.studies.drawing.panels import open_one


def text_of(*assignments):
    return dumps(load(Machine, assignments=assignments))


def test_the_conditions_are_the_supply_and_where_the_machine_deviates():
    assert conditions_of(text_of()) == "supply 1 MPa gauge, 287 K; default machine"
    changed = text_of("supply.pressure=0.6 MPa gauge", "engine.bore=90 mm", "effects.blow_by.area=0.2 mm^2")
    told = conditions_of(changed, more="50 ms pulse")
    assert told.startswith("supply 0.6 MPa gauge, 287 K; 50 ms pulse; default machine but for engine.bore = 90 mm")
    assert "effects.blow_by.area = 0.2 mm^2" in told


def test_what_a_figure_shows_over_a_range_is_no_condition():
    changed = text_of("supply.pressure=0.6 MPa gauge", "engine.bore=90 mm")
    assert conditions_of(changed, (*SUPPLY, "engine.bore")) == "default machine"


def test_the_pressure_of_the_control_air_is_named_with_the_supply():
    machine = text_of("supply.control_pressure=0.8 MPa gauge")
    assert conditions_of(machine) == "supply 1 MPa gauge, 287 K, control air 0.8 MPa gauge; default machine"
    assert conditions_of(machine, CONTROL_AIR) == "default machine"


def test_what_a_valve_alone_does_not_know_is_no_condition():
    machine = text_of("engine.bore=90 mm", "command.release=60 deg", "valve.stroke=6 mm")
    assert conditions_of(machine, CONTROL_AIR, sections=VALVE_SECTIONS) == "default valve but for valve.stroke = 6 mm"


def test_a_number_has_no_more_digits_than_a_reader_wants():
    told = conditions_of(text_of("valve.viscous_friction=110.98935711061777 N s/m"), SUPPLY)
    assert told == "default machine but for valve.viscous_friction = 110.989 N s/m"


@pytest.mark.parametrize("width", [4.0, 9.0])
def test_many_deviations_are_counted_and_broken_into_lines_as_long_as_the_figure_is_wide(width, tmp_path):
    keys = (
        "bore=90 mm",
        "stroke=80 mm",
        "rod_length=160 mm",
        "pin_offset=1 mm",
        "compression_ratio=12",
        "cam.lift=5 mm",
    )
    keys = [f"engine.{key}" for key in keys]
    keys += ["groove.lap=2 mm", "valve.stroke=8 mm", "valve.moving_mass=0.2 kg", "command.release=60 deg"]
    told = conditions_of(text_of(*keys))
    assert told.endswith("2 more keys")
    figure, _ = open_one((width, 3.0))
    save(figure, tmp_path, "figure", told)
    [foot] = figure.texts
    assert foot.get_text().replace("\n", " ") == told
    assert 0.6 * figure.bbox.width < foot.get_window_extent().width < figure.bbox.width


@pytest.mark.parametrize("where", ["outside lower center", "outside right upper", "upper left"])
def test_the_conditions_stand_below_the_figure_and_move_nothing(where, tmp_path):
    def drawn(conditions):
        figure, axis = open_one((5.0, 3.0))
        axis.plot([0.0, 1.0], [0.0, 1.0], label="a line")
        legend = figure.legend(loc=where)
        paths = save(figure, tmp_path, f"with{len(conditions)}", conditions)
        return plt.imread(paths[0]), legend

    plain, _ = drawn("")
    told, _ = drawn("supply 1 MPa gauge, 287 K; default machine")
    assert plain.shape[1] == told.shape[1] and plain.shape[0] < told.shape[0] < plain.shape[0] + 60
    same = (abs(plain - told[: plain.shape[0]]) < 0.02).mean()
    assert same > 0.995
    assert told[plain.shape[0] :].min() < 0.6
