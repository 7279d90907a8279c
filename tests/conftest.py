"""Marks the tests that also pass with compilation switched off: ``NUMBA_DISABLE_JIT=1 python -m pytest -m plain``."""

import pytest

PLAIN = {
    *("test_air", "test_effect", "test_march", "test_periodic", "test_solenoid", "test_chamber", "test_groove"),
    *("test_piston", "test_motion", "test_measures", "test_bench", "test_valve_effects", "test_kinematics"),
    *("test_breathing", "test_friction", "test_cycle", "test_operating_point", "test_engine_effects"),
    *("test_reference_valve",),
}


def pytest_collection_modifyitems(items):
    for item in items:
        if item.path.stem in PLAIN:
            item.add_marker(pytest.mark.plain)
