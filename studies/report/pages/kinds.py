"""Which page belongs to which kind of archive; a new kind is one more entry."""

from collections.abc import Callable
from functools import partial

from apesim.studies.archives.archive_result import ArchiveResult
from apesim.studies.report.pages.grid import GridPage, write_grid
from apesim.studies.report.pages.march import write_start, write_transient
from apesim.studies.report.pages.starts import write_starts
from apesim.studies.report.pages.sweep import write_sweep
from apesim.studies.report.sections import Content

GRID_PAGES = {
    "engine limit": GridPage(
        "Highest speed at which the timing is met",
        [("limit_rpm",), ("lap_to_lap_s", "rule_lap_to_lap_s"), ("energise_deg", "release_deg"), ("peak_lift_m",)],
        ["limit_rpm", "fails", "works_again_rpm", "lap_to_lap_s", "energise_deg", "release_deg", "peak_lift_m"],
    ),
    "engine timing": GridPage(
        "Commands that open and close the valve at its targets",
        [
            ("advance_deg",),
            ("release_advance_deg",),
            ("energise_deg",),
            ("release_deg",),
            ("brake_torque_Nm",),
            ("fixed_brake_torque_Nm",),
            ("specific_air_kg_per_kWh",),
            ("fixed_specific_air_kg_per_kWh",),
        ],
        ["reachable", "reason", "energise_deg", "release_deg", "advance_deg", "release_advance_deg", "brake_torque_Nm"],
    ),
    "engine optimise": GridPage(
        "The best commands",
        [
            ("fixed_brake_torque_Nm", "most_torque_brake_torque_Nm", "least_air_brake_torque_Nm"),
            (
                "fixed_specific_air_kg_per_kWh",
                "most_torque_specific_air_kg_per_kWh",
                "least_air_specific_air_kg_per_kWh",
            ),
            ("fixed_energise_deg", "most_torque_energise_deg", "least_air_energise_deg"),
            ("fixed_release_deg", "most_torque_release_deg", "least_air_release_deg"),
        ],
        clouds=[("front_specific_air_kg_per_kWh", "front_brake_torque_Nm")],
    ),
    "engine assess": GridPage(
        "What the valve's faults cost",
        [
            ("brake_torque_Nm",),
            ("specific_air_kg_per_kWh",),
            ("brake_torque_lost_Nm",),
            ("specific_air_added_kg_per_kWh",),
            ("opening_lateness_deg", "opening_delay_deg", "opening_travel_deg"),
            ("closing_lateness_deg", "closing_delay_deg", "closing_travel_deg"),
        ],
        ["outcome", "opening_lateness_deg", "closing_lateness_deg", "peak_lift_m", "cycle_to_cycle_torque_Nm"],
    ),
    "valve map": GridPage(
        "The valve over pressure and temperature",
        [
            ("opening_delay_s",),
            ("closing_delay_s",),
            ("opening_stroke_time_s",),
            ("closing_stroke_time_s",),
            ("opening_seating_speed_m_s",),
            ("closing_seating_speed_m_s",),
        ],
        traces=[("lift",), ("velocity",), ("pressure_a",), ("pressure_b",)],
        is_valve=True,
    ),
    "valve limit": GridPage(
        "Highest working rate of the valve",
        [("limit_hz",), ("limit_rpm",), ("lap_to_lap_s", "rule_lap_to_lap_s"), ("window_deg",)],
        ["limit_hz", "limit_rpm", "complete_again_hz", "lap_to_lap_s", "window_deg", "outcome"],
    ),
    "valve soft-landing": GridPage(
        "Brakes that lower the seating speed",
        [
            ("opening_within_spacing_front_speed", "opening_any_spacing_front_speed"),
            ("closing_within_spacing_front_speed", "closing_any_spacing_front_speed"),
            ("opening_speed_over_spacing",),
            ("closing_speed_over_spacing",),
        ],
        [
            *("opening_seating_speed", "opening_within_spacing_softest_speed", "opening_within_spacing_softest_added"),
            *("closing_seating_speed", "closing_within_spacing_softest_speed", "closing_within_spacing_softest_added"),
        ],
        {
            "opening_within_spacing_front_speed": "lowest seating speed, opening",
            "closing_within_spacing_front_speed": "lowest seating speed, closing",
            "opening_speed_over_spacing": "lowest seating speed, opening",
            "closing_speed_over_spacing": "lowest seating speed, closing",
        },
    ),
}
"""What the pages of studies over a grid show first, by kind."""
PAGES: dict[str, Callable[[ArchiveResult], Content]] = {
    "engine sweep": write_sweep,
    "engine start": write_start,
    "engine start map": write_starts,
    "engine transient": write_transient,
    **{kind: partial(write_grid, page=page) for kind, page in GRID_PAGES.items()},
}
"""What writes the page of each kind."""
BARE = partial(write_grid, page=GridPage("An archive"))
"""What writes the page of an archive of no known kind."""
