"""What a folder says of how far the rig is known: read by the machine's own keys, refused by name where it is wrong."""

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.engine.stated_uncertainties import list_leaves, name_key, read_known_to
from apesim.quantities import InputError
from apesim.quantities.uncertainties import Uncertainty
from apesim.studies.measured import VALVE, MeasuredRun, read_measured
from apesim.studies.measured.prediction import predict, run_of, with_value
from apesim.studies.measured.runs import BENCHES
from apesim.studies.measured.stated_uncertainties import SECTIONS, matters
from tests.machines import AMBIENT

RUN = '[[run]]\ndata = "a.csv"\nsupply = "0.40 MPa gauge"\ntemperature = "287 K"\npulse = "50 ms"\n'
ROWS = "".join(f"{0.5 * i},{0.01 * i}\n" for i in range(10))


@pytest.fixture
def folder(tmp_path):
    """Writes measured.toml with a table known_to; returns its folder."""

    def write(*lines, bench="valve"):
        text = "\n".join([f'bench = "{bench}"', *lines, RUN])
        (tmp_path / "measured.toml").write_text(text)
        (tmp_path / "a.csv").write_text(f"time [ms],lift [mm]\n{ROWS}")
        return tmp_path

    return write


def faults(folder):
    """The lines of what is wrong with a folder, less its path."""
    with pytest.raises(InputError) as caught:
        read_measured(folder, AMBIENT)
    return str(caught.value).replace(f"{folder}/", "").splitlines()


def test_dots_of_a_key_may_stand_in_quotes_or_not(folder):
    quoted = folder(
        "[known_to]", '"valve.stroke" = "0.05 mm"', '"sensor.lift.gain" = "0.2 %"', '"supply.pressure" = "2 %"'
    )
    right = {
        "valve.stroke": Uncertainty(5e-5),
        "effects.sensor_gain.lift": Uncertainty(0.002),
        "supply.pressure": Uncertainty(0.02, is_share=True),
    }
    assert read_measured(quoted, AMBIENT).known_to == right
    bare = folder("[known_to]", 'valve.stroke = "0.05 mm"', 'sensor.lift.gain = "0.2 %"', 'supply.pressure = "2 %"')
    assert read_measured(bare, AMBIENT).known_to == right
    assert read_measured(folder(), AMBIENT).known_to == {}


def test_every_fault_is_told_at_once_with_the_right_form(folder):
    lines = [
        ('"valve.strok" = "1 %"', "valve.strok: unknown key; did you mean valve.stroke?"),
        ('"stroke" = "1 %"', "stroke: unknown key; did you mean valve.stroke or engine.stroke?"),
        ('"sensor.lift.gian" = "1 %"', "sensor.lift.gian: unknown key; did you mean sensor.lift.gain?"),
        (
            '"effects.sensor_gain.lift" = "1 %"',
            "effects.sensor_gain.lift: is named by its sensor here; write sensor.lift.gain",
        ),
        (
            '"supply.control_pressure" = "1 %"',
            "supply.control_pressure: is what runs state; write supply.pressure or supply.temperature",
        ),
        (
            '"engine.intake" = "1 %"',
            "engine.intake: is no number that can be known within a standard deviation; leave it out",
        ),
        (
            '"supply.pressure" = "5 kPa"',
            "supply.pressure: '5 kPa' is no share; write a share of the pressure above ambient, as a gauge errs, "
            'e.g. "1 %"',
        ),
        (
            '"valve.piston_area" = "3 mm"',
            "valve.piston_area: '3 mm': 'mm' cannot be converted to mm^2; write e.g. \"1 %\" or \"11 mm^2\"",
        ),
        ('"engine.bore" = "1 %"', "engine.bore: cannot matter on the valve's bench; leave it out"),
        ('"sensor.torque.gain" = "1 %"', "sensor.torque.gain: cannot matter on the valve's bench; leave it out"),
    ]
    found = faults(folder("[known_to]", *(line for line, _ in lines)))
    assert sorted(found) == sorted(f"measured.toml: known_to.{right}" for _, right in lines)
    assert faults(folder('known_to = "1 %"')) == [
        'measured.toml: known_to: \'1 %\' is no table; write [known_to] and "valve.stroke" = "0.05 mm"'
    ]


def test_a_key_that_is_there_in_both_ways_is_refused(folder):
    twice = folder("[known_to]", '"valve.stroke" = "1 %"', 'valve.stroke = "2 %"')
    assert faults(twice) == ["measured.toml: known_to.valve.stroke: is given twice; give it once"]


def test_a_sensor_that_no_run_has_is_not_used_and_told(folder):
    measured = read_measured(folder("[known_to]", '"sensor.pressure_b.offset" = "1 kPa"'), AMBIENT)
    assert measured.hints == ('known_to."sensor.pressure_b.offset" is not used: no run has pressure_b',)


def test_every_name_is_of_one_number_and_is_read_back():
    names = {name_key(key): key for key in list_leaves()}
    assert len(names) == len(list_leaves())
    known_to, faults = read_known_to(dict.fromkeys(names, "exact"))
    assert not faults
    assert set(known_to) == set(list_leaves())
    sections = {key.partition(".")[0] for key in known_to if not any(matters(key, bench) for bench in BENCHES)}
    assert sections == {"command", "shaft", "load", "stage_2", "inter_receiver"}


@pytest.mark.parametrize("section", ["groove", "engine", "command"])
def test_a_section_that_is_refused_on_the_valves_bench_changes_nothing_there(section):
    assert section not in SECTIONS[VALVE]
    times = np.arange(0.0, 0.06, 2e-3)
    run = MeasuredRun("a", "a.csv", AMBIENT + 0.4e6, 287.0, 30e-3, "fit", times, {"lift": times, "pressure_a": times})
    machine = changed = run_of(Machine(), run)
    for key, leaf in list_leaves().items():
        if key.startswith(f"{section}."):
            changed = with_value(changed, key, 1.05 * leaf.default)
    assert changed != machine
    plain, moved = (predict(each, run).channels for each in (machine, changed))
    for sensor in run.channels:  # where the groove opens is located, which moves the steps of the march
        assert moved[sensor] == pytest.approx(plain[sensor], rel=1e-6, abs=1e-6 * np.abs(plain[sensor]).max())


# --- scatter ---


def test_a_scatter_is_read_like_what_is_known_of_a_number(folder):
    stated = folder("[scatter]", '"supply.pressure" = "0.3 %"', 'valve.solenoid.dead_time = "0.03 ms"')
    assert read_measured(stated, AMBIENT).scatter == {
        "supply.pressure": Uncertainty(0.003, True),
        "valve.solenoid.dead_time": Uncertainty(0.03e-3),
    }
    assert read_measured(folder(), AMBIENT).scatter == {}


def test_every_fault_of_a_scatter_is_named(folder):
    keys = "supply.pressure, supply.temperature, valve.viscous_friction or valve.solenoid.dead_time"
    lines = [
        ('"valve.stroke" = "1 %"', f"valve.stroke: is no number that may scatter; write {keys}"),
        ('"supply.pressure" = "3 kPa"', None),
        ('"supply.temperature" = "1 %"', None),
        ('"valve.viscous_friction" = "-3 %"', None),
    ]
    found = faults(folder("[scatter]", *(line for line, _ in lines)))
    assert found[-1] == f"measured.toml: scatter.{lines[0][1]}"
    assert [text.split(": ")[1] for text in found[:-1]] == [
        "scatter.supply.pressure",
        "scatter.supply.temperature",
        "scatter.valve.viscous_friction",
    ]
    twice = folder("[scatter]", '"supply.pressure" = "1 %"', 'supply.pressure = "2 %"')
    assert faults(twice) == ["measured.toml: scatter.supply.pressure: is given twice; give it once"]
    assert faults(folder('scatter = "1 %"')) == [
        'measured.toml: scatter: \'1 %\' is no table; write [scatter] and "supply.pressure" = "0.3 %"'
    ]
