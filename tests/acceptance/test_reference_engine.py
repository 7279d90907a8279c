"""The engine against independent solutions (DOP853, rtol 1e-9, 30-40 cycles) at the defaults.

Equations 1-8 of doi 10.1631/jzus.A0820373 for the valve, mass and energy of one zone for the cylinder. Stated error:
2e-5 of each number and 1e-3 degrees of each angle at the default tolerance. An empty cell: it never comes to it, or
there is none.
"""

import numpy as np
import pytest

from apesim.engine.indicators import indicators
from tests.machines import agrees, machine, reference, settled

ERROR, ANGLE_ERROR = 2e-5, 1e-3
COLUMNS = {
    "indicated torque [N m]": ("indicated_torque_Nm", 1.0),
    "engine air [g/cycle]": ("engine_air_kg_per_cycle", 1e3),
    "control air [g/cycle]": ("control_air_kg_per_cycle", 1e3),
    "full open at [deg]": ("full_open_deg", 1.0),
    "closed at [deg]": ("closed_deg", 1.0),
    "opening seating speed [m/s]": ("opening_seating_speed_m_s", 1.0),
    "closing seating speed [m/s]": ("closing_seating_speed_m_s", 1.0),
    "peak lift [mm]": ("peak_lift_m", 1e3),
    "peak cylinder pressure [kPa abs]": ("peak_cylinder_pressure_Pa", 1e-3),
}
VALVE = ("control air [g/cycle]", "full open at [deg]", "closed at [deg]", "peak lift [mm]")
OF_A_CAM = {"full_open_deg", "closed_deg", "peak_lift_m"}
"""What the columns leave out for a cam and the ideal valve, where we know it by definition."""
VARIANTS = {
    "receiver 1 L": {"receiver": 1.0},
    "control air from it": {"control_air": "receiver"},
    "pin offset 5 mm": {"engine__pin_offset": 5e-3},
    "wall heat 200 W/(m2 K) at 300 K": {
        "effects__cylinder_wall_heat__h": 200.0,
        "effects__cylinder_wall_heat__wall_temperature": 300.0,
    },
    "blow-by 0.5 mm2": {"effects__blow_by__area": 0.5e-6},
}
ROWS = reference("reference-engine.csv")


def machine_of(row):
    intake, *variants = row["case"].split("; ")
    values = {name: value for variant in variants for name, value in VARIANTS[variant].items()}
    supply, energise, release = (float(row[name]) for name in ("supply [MPa gauge]", "energise [deg]", "release [deg]"))
    return machine(intake=intake, supply=supply, energise=energise, release=release, **values)


def results(row):
    a_machine = machine_of(row)
    return indicators(a_machine, settled(a_machine, float(row["speed [rpm]"])))


def row_of(case, speed="800"):
    (row,) = (row for row in ROWS if row["case"] == case and row["speed [rpm]"] == speed)
    return row


def test_all_rows_are_there():
    assert len(ROWS) == 14


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row['case']}, {row['speed [rpm]']} rpm")
def test_engine_repeats_the_independent_solution(row):
    found, wrong = results(row), {}
    for column, (name, factor) in COLUMNS.items():
        text, number = row[column], found[name] * factor
        if not text and not row["case"].startswith("epv"):
            assert name in OF_A_CAM or name == "control_air_kg_per_cycle" or np.isnan(number)
            continue
        by = ANGLE_ERROR if "[deg]" in column else 0.0
        if not agrees(number, text, 0.0 if by else ERROR, by):
            wrong[column] = number, text
    assert not wrong


def test_cam_and_ideal_valve_take_no_control_air():
    for case in ("cam", "ideal"):
        assert results(row_of(case, "1000"))["control_air_kg_per_cycle"] == 0.0


def test_control_air_from_the_receiver_lets_the_cylinder_act_on_the_valve():
    """The receiver's pressure swings with the breathing: the coupling runs both ways."""
    regulated = results(row_of("epv; receiver 1 L"))
    coupled = results(row_of("epv; receiver 1 L; control air from it"))
    for name in ("full_open_deg", "closed_deg"):
        assert abs(coupled[name] - regulated[name]) > 20.0 * ANGLE_ERROR
    assert coupled["closing_seating_speed_m_s"] > 1.02 * regulated["closing_seating_speed_m_s"]


def test_with_control_air_from_the_regulator_the_cylinder_does_not_act_on_the_valve():
    alone = results(row_of("epv"))
    for case in (row["case"] for row in ROWS if row["speed [rpm]"] == "800" and "control air" not in row["case"]):
        found = results(row_of(case))
        for name in (COLUMNS[column][0] for column in VALVE):
            assert found[name] == pytest.approx(alone[name], rel=ERROR / 10.0), (case, name)
