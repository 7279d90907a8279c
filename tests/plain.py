"""Test files that pass without compiling, too; their tests that take long so are marked `compiled`."""

QUICK = {
    *("test_air", "test_effect", "test_adaptive", "test_periodic", "test_solenoid", "test_chamber", "test_groove"),
    *("test_piston", "test_ledger", "test_motion", "test_measures", "test_tabulated_effects", "test_kinematics"),
    *("test_cam", "test_friction", "test_operating_point", "test_rosenbrock", "test_restriction", "test_rig"),
    *("test_machine", "test_ideal_work", "test_theory", "test_gas_exchange", "test_outside_machine", "test_exergy"),
    *("test_ports", "test_stated_uncertainties", "test_engine_adjustments", "test_sensor_effects", "test_machine_file"),
}
"""Stems of files that take seconds without compiling; of the effects, the tables."""
LONG = {
    *("test_bench", "test_valve_effects", "test_rates", "test_engine_effects", "test_reference_valve"),
    *("test_solenoid_effects", "test_chamber_effects", "test_piston_effects", "test_bounce", "test_indicators"),
    *("test_steady", "test_warnings"),
}
"""Stems of files with so many marches that they take minutes without compiling.

Each effect's law runs as plain Python in the examples of the docstrings, too.
"""
