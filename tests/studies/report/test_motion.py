"""The picture that moves is to scale, and its script moves it as Python draws it."""

import re
from cmath import exp
from math import nan, radians

import pytest

from apesim.engine.kinematics import crank_of, cylinder_volume
from apesim.engine.machine import Machine
from apesim.studies.report.motion import Snapshot, motion_geometry, render_motion, shapes_of, share_of_colour

OFFSET = Machine().with_(engine_pin_offset="8 mm")


def attributes(fragment: str, part: str) -> dict[str, str]:
    """Attributes of the part with a name in a fragment."""
    (tag,) = re.findall(rf'<[^>]*data-part="{part}"[^>]*>', fragment)
    return dict(re.findall(r'([\w-]+)="([^"]*)"', tag))


@pytest.mark.parametrize("angle", [0.0, 35.0, 150.0, 301.0])
def test_the_charge_is_drawn_as_high_as_its_volume(angle: float) -> None:
    crank, sheet = crank_of(OFFSET.engine), shapes_of(OFFSET).engine_sheet
    volume, _ = cylinder_volume(crank, radians(angle))
    drawn = attributes(render_motion(OFFSET, Snapshot(angle), 1e6), "charge")
    assert float(drawn["height"]) / sheet.scale == pytest.approx(1e3 * volume / crank.face, abs=0.02)


def test_the_rod_joins_the_pins() -> None:
    angle = 70.0
    place = attributes(render_motion(OFFSET, Snapshot(angle), 1e6), "rod")["transform"]
    x, y, turned = map(float, re.findall(r"[-\d.]+", place))
    engine, sheet = shapes_of(OFFSET).engine, shapes_of(OFFSET).engine_sheet
    end = complex(x, y) + sheet.scale * engine.rod * 1j * exp(1j * radians(turned))
    pin = engine.crank_pin(radians(angle))
    assert (end.real, end.imag) == pytest.approx((sheet.x(pin[0]), sheet.y(pin[1])), abs=0.05)


def test_the_groove_meets_its_port_at_the_lap() -> None:
    valve = shapes_of(Machine()).valve
    rim = max(y for x, y in valve.piston_outline() if abs(x) < 0.5 * valve.diameter)
    assert rim + 1e3 * Machine().groove.lap == pytest.approx(valve.port)
    assert rim + 1e3 * Machine().valve.stroke == pytest.approx(valve.port + valve.groove)


def test_the_air_has_the_colour_of_its_pressure() -> None:
    fragment = render_motion(Machine(), Snapshot(10.0, 0.0, 6e5, 1e5, 3.5e5, 1e6), 1.1e6)
    shares = dict(re.findall(r'data-air="(\w+)" style="--high:([\d.]+)%"', fragment))
    lowest = Machine().ambient.pressure
    assert {name: float(share) for name, share in shares.items()} == {
        name: pytest.approx(100.0 * (pressure - lowest) / (1.1e6 - lowest), rel=5e-3)
        for name, pressure in (("a", 6e5), ("b", lowest), ("cylinder", 3.5e5), ("receiver", 1e6))
    }
    assert share_of_colour(nan, 1e5, 1e6) == "0%"


RECTANGLE = r'<rect x="([-\d.]+)" y="([-\d.]+)" width="([-\d.]+)" height="([-\d.]+)"'
PISTON = r'<g data-part="piston".*?</g>'
ODD = {
    "engine_receiver_volume": "inf",
    "valve_stroke": "6 mm",
    "engine_bore": "300 mm",
    "engine_stroke": "20 mm",
}


@pytest.mark.parametrize("keys", [ODD, {"engine_intake": "cam"}, {"engine_intake": "ideal"}])
def test_the_picture_of_an_odd_machine_holds_all_of_it(keys: dict[str, str]) -> None:
    machine = Machine().with_(**keys)
    fragment = render_motion(machine, Snapshot(200.0, 0.5 * machine.valve.stroke), 1e6)
    assert "nan" not in fragment and "inf" not in fragment
    for picture in re.findall(r"<svg.*?</svg>", re.sub(PISTON, "", fragment)):
        width, height = map(float, re.findall(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', picture)[0])
        boxes = [[float(each) for each in box] for box in re.findall(RECTANGLE, picture)]
        assert boxes
        assert all(x >= 0.0 and y >= 0.0 and x + w <= width and y + h <= height for x, y, w, h in boxes)


def test_a_valve_alone_has_no_engine() -> None:
    assert motion_geometry(Machine(), 1e6, has_engine=False)["engine"] is None
    assert render_motion(Machine(), Snapshot(), 1e6, has_engine=False).count("<svg") == 1
