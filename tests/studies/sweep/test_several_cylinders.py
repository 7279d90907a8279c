"""Sweeps over engines of several cylinders: totals in the usual columns, and each valve in columns of its own."""

import numpy as np
import pytest

import apesim
from apesim import Machine

OWN = [{}, {"valve.solenoid.dead_time": "2.5 ms"}, {}]
SWEPT = {"speed": "600 rpm, 900 rpm", "intake": "epv", "timing": "fixed"}


@pytest.fixture(scope="module")
def swept():
    return apesim.sweep(Machine().with_(ambient_temperature="300 K"), **SWEPT, vary={"engine.cylinders": "1:3:1"})


def test_a_run_is_what_it_is_alone(swept):
    alone = apesim.run_engine(Machine().with_(ambient_temperature="300 K", engine_cylinders=3), "900 rpm")
    at = (swept.traces["engine_cylinders"].values == 3) & (swept.traces["speed_rpm"].values == 900.0)
    for name in ("brake_torque", "valve_open_deg", "torque_ripple", "receiver_dip"):
        assert swept.traces[name].values[at] == alone[name]
    lift = swept.traces["cylinder_lift"]
    assert lift.dims == ("run", "cylinder", "crank_angle_deg")
    assert np.array_equal(lift.values[at][0], alone.traces["lift"].values.T)
    assert np.allclose(swept.traces["torque"].values[at][0], alone.traces["gas_torque"].values, rtol=1e-12)


def test_a_run_of_fewer_cylinders_has_none_in_the_places_of_the_others(swept):
    opens, count = swept.traces["cylinder_valve_open_deg"].values, swept.traces["engine_cylinders"].values
    assert np.array_equal((~np.isnan(opens)).sum(axis=1), count)
    assert np.array_equal(opens[:, 0], swept.traces["valve_open_deg"].values)


def test_shards_of_several_cylinders_merge_to_the_whole(tmp_path):
    machine = Machine().with_(engine_cylinders=3, cylinder=OWN)
    whole = apesim.sweep(machine, **SWEPT, out=tmp_path / "whole.h5")
    for i in (1, 2):
        apesim.sweep(machine, **SWEPT, out=tmp_path / f"{i}.h5", shard=f"{i}/2")
    apesim.merge_archives([tmp_path / "1.h5", tmp_path / "2.h5"], tmp_path / "merged.h5")
    opens = whole.traces["cylinder_valve_open_deg"].values
    assert np.allclose(opens[:, 1] - opens[:, 0], [3.6, 5.4], atol=0.05)  # 1 ms later
    assert apesim.compare_archives(tmp_path / "whole.h5", tmp_path / "merged.h5")["differences"] == 0


def test_one_cylinder_has_no_columns_of_its_own():
    one = apesim.sweep(Machine(), **SWEPT)
    assert not [name for name in one.traces if name.startswith("cylinder_valve")]


def test_it_lays_out_over_what_was_swept(swept):
    pytest.importorskip("xarray")
    data = swept.to_xarray()
    assert dict(data["cylinder_valve_open_deg"].sizes) == {
        "actuation": 1,
        "engine_cylinders": 3,
        "speed_rpm": 2,
        "cylinder": 3,
    }


def test_parts_with_other_numbers_of_cylinders_join_to_the_whole(tmp_path):
    point = {"speed": "600 rpm", "intake": "epv", "timing": "fixed", "vary": {"engine.cylinders": "1:3:1"}}
    for i in (1, 2, 3):
        apesim.sweep(Machine(), **point, out=tmp_path / f"{i}.h5", shard=f"{i}/3")
    apesim.sweep(Machine(), **point, out=tmp_path / "whole.h5")
    apesim.merge_archives([tmp_path / f"{i}.h5" for i in (1, 2, 3)], tmp_path / "merged.h5")
    assert apesim.compare_archives(tmp_path / "whole.h5", tmp_path / "merged.h5")["differences"] == 0
    opens = apesim.read_archive(tmp_path / "merged.h5").traces["cylinder_valve_open_deg"].values
    assert np.array_equal((~np.isnan(opens)).sum(axis=1), [1, 2, 3])
