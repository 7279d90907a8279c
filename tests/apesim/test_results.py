"""Results know their names and units, say themselves in a few lines, and never change."""

import builtins
import copy
import dataclasses
import math
import pickle
from typing import ClassVar

import numpy as np
import pytest

from apesim.results import NotConverged, Result, Scalar, Trace, name_of, scalars_of

DECLARED = {
    "brake_torque_Nm": ("N m", "mean brake torque"),
    "speed_rpm": ("r/min", "speed"),
    "specific_air_kg_per_kWh": ("kg/kWh", "all air over brake work"),
    "converged": ("1", "whether the state repeats"),
}


class Run(Result):
    title: ClassVar[str] = "a run <b>of ours</b>"


def run_of(**other):
    angles = np.arange(0.0, 360.0, 0.5)
    return Run(
        scalars_of(
            {"brake_torque_Nm": 31.25, "speed_rpm": 1e3, "specific_air_kg_per_kWh": math.nan, "converged": True},
            DECLARED,
        ),
        {
            "crank_angle_deg": Trace(("crank_angle_deg",), angles, "deg", "crank angle after TDC"),
            "lift": Trace(("crank_angle_deg",), 1e-3 * np.sin(np.radians(angles)) ** 2, "m", "lift"),
        },
        {"speed": "1000 r/min"},
        **other,
    )


def test_a_number_is_found_by_its_name_with_and_without_its_si_unit():
    run = run_of()
    assert run["brake_torque"] == run["brake_torque_Nm"] == 31.25
    assert run["speed_rpm"] == 1000.0 and math.isnan(run["specific_air_kg_per_kWh"]) and run["converged"] is True
    assert list(run) == ["brake_torque", "speed_rpm", "specific_air_kg_per_kWh", "converged"]


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("speed", "did you mean speed_rpm?"),  # it would be taken for rad/s
        ("specific_air", "did you mean specific_air_kg_per_kWh?"),
        ("brake_tork", "did you mean brake_torque?"),
        ("lift", "write .traces['lift']"),
        ("xyz", "there are brake_torque, speed_rpm"),
    ],
)
def test_a_name_that_is_none_is_refused_with_the_nearest_right_one(name, told):
    with pytest.raises(KeyError) as caught:
        run_of()[name]
    assert told in str(caught.value)


def test_names_that_fall_together_are_refused():
    with pytest.raises(ValueError, match="there is a delay already"):
        scalars_of({"delay": 1.0, "delay_s": 2.0}, {"delay": ("1", ""), "delay_s": ("s", "")})


def test_a_name_says_every_unit_that_is_not_si():
    assert name_of("seating_speed_m_s", "m/s") == "seating_speed"
    assert name_of("lift", "m") == "lift"
    assert name_of("crank_angle", "deg") == name_of("crank_angle_deg", "deg") == "crank_angle_deg"


def test_a_trace_is_an_array_that_cannot_be_written():
    source = np.arange(3.0)
    trace = Trace(("time",), source, "s", "time")
    assert np.array_equal(np.asarray(trace), source) and trace[1] == 1.0 and len(trace) == 3
    assert np.max(2.0 * np.asarray(trace)) == 4.0
    with pytest.raises(ValueError, match="read-only"):
        trace.values[0] = 1.0
    source[0] = 0.5
    assert trace[0] == 0.0
    with pytest.raises(ValueError, match="axes"):
        Trace(("time", "run"), source)


def test_a_result_never_changes():
    run = run_of()
    for change in (
        lambda: setattr(run, "warnings", ()),
        lambda: run.scalars.__setitem__("x", Scalar(1.0)),
        lambda: setattr(run.scalars["brake_torque"], "value", 0.0),
        lambda: run.traces.pop("lift"),
    ):
        with pytest.raises((AttributeError, TypeError)):
            change()
    conditions = {"speed": "1000 r/min"}
    other = Result({}, {}, conditions)
    conditions["speed"] = "another"
    assert other.conditions["speed"] == "1000 r/min"


def test_a_short_text_holds_the_numbers_with_units_and_no_array():
    many = {f"number_{place}": Scalar(float(place)) for place in range(40)}
    warnings = ["the first warning " * 20, *("another",) * 30]
    for run in (run_of(), run_of(warnings=warnings, ending="periodic"), Run(many, run_of().traces, {}, warnings)):
        text = repr(run)
        assert len(text.splitlines()) < 12 and "array" not in text and "[0" not in text
        assert max(map(len, text.splitlines())) < 140
    text = repr(run_of(ending="periodic after 28 cycles (period: 1 cycle)", warnings=warnings))
    assert "31.25 N m" in text and "1000 r/min" in text and "specific_air_kg_per_kWh  - kg/kWh" in text
    assert "periodic after 28 cycles" in text and "(and 30 more in .warnings)" in text
    assert repr(run_of().traces["lift"]) == "<Trace [m] over 720 crank_angle_deg, 0 to 0.001>"


def test_html_escapes_whatever_it_holds():
    evil = '<script>"&'
    run = Run({evil: Scalar(1.0, evil, evil)}, {}, {evil: evil}, [evil], evil)
    page = run._repr_html_()
    assert "<script" not in page and "<b>" not in page and page.count("&lt;script&gt;&quot;&amp;") >= 6
    assert "31.25" in run_of()._repr_html_() and "N m" in run_of()._repr_html_()


def test_xarray_has_units_and_long_names():
    pytest.importorskip("xarray")
    data = run_of(warnings=["one", "two"], machine="[engine]").to_xarray()
    assert data["brake_torque"].item() == 31.25
    assert data["brake_torque"].attrs == {"units": "N m", "long_name": "mean brake torque"}
    assert data["lift"].dims == ("crank_angle_deg",) and data["lift"].attrs["units"] == "m"
    assert data["crank_angle_deg"].attrs["units"] == "degree" and "crank_angle_deg" in data.coords
    assert data.attrs["speed"] == "1000 r/min" and data.attrs["warnings"] == "one\ntwo"
    pressure = Result({"pressure": Scalar(1e5, "Pa abs", "pressure")}).to_xarray()["pressure"]
    assert pressure.attrs == {"units": "Pa", "long_name": "pressure", "reference": "absolute"}
    assert float(data["lift"].sel(crank_angle_deg=90.0)) == pytest.approx(1e-3)


def test_pandas_has_units():
    pandas = pytest.importorskip("pandas")
    frame = run_of().to_pandas()
    assert isinstance(frame, pandas.DataFrame) and frame.index.name == "crank_angle_deg" and list(frame) == ["lift"]
    assert frame.attrs["units"] == {"crank_angle_deg": "deg", "lift": "m"}
    assert frame.attrs["scalars"]["brake_torque"] == 31.25
    [row] = Run(run_of().scalars).to_pandas().itertuples()
    assert row.brake_torque == 31.25 and row.speed_rpm == 1000.0


@pytest.mark.parametrize("package", ["xarray", "pandas"])
def test_a_package_that_is_missing_is_named_with_how_to_install_it(monkeypatch, package):
    real = builtins.__import__

    def without(name, *arguments, **options):
        if name == package:
            raise ImportError
        return real(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", without)
    monkeypatch.setattr("importlib.import_module", without)
    with pytest.raises(ImportError, match=rf'pip install "apesim\[{package}\]"'):
        getattr(run_of(), f"to_{package}")()


def test_what_did_not_converge_carries_its_result_and_a_remedy():
    run = run_of(converged=False)
    error = NotConverged("epv at 1000 r/min", "not periodic after 400 cycles", "give a smaller receiver", run)
    assert error.result is run and error.remedy == "give a smaller receiver"
    assert str(error) == "epv at 1000 r/min: not periodic after 400 cycles; give a smaller receiver"


def test_the_text_of_the_machine_is_written_once_when_it_is_first_read():
    written = []

    def write():
        written.append(None)
        return "[engine]"

    run = run_of(machine=write)
    assert not written
    assert run.machine == run.machine == "[engine]" and len(written) == 1
    assert run == run_of(machine="[engine]") != run_of(machine="[valve]")
    assert run_of().machine == ""
    with pytest.raises(dataclasses.FrozenInstanceError):
        run.machine = ""


def test_a_result_is_pickled_with_the_text_of_its_machine():
    run = run_of(machine=lambda: "[engine]")  # which itself cannot be pickled
    assert pickle.loads(pickle.dumps(run)).machine == copy.deepcopy(run).machine == "[engine]"


def test_a_wrong_name_of_a_trace_is_answered_with_the_nearest_after_pickling_too():
    run = Result({}, {"lift": Trace(("time",), np.arange(3.0), "m", "lift")})
    for each in (run, pickle.loads(pickle.dumps(run))):
        with pytest.raises(KeyError, match=r"no lif; did you mean lift\?"):
            each.traces["lif"]
        assert "lif" not in each.traces and each.traces.get("lif") is None


def test_a_notebook_shows_a_trace_in_little_room():
    rising = Trace(("time",), np.linspace(0.0, 9e-3, 100_000), "m", "lift <b>")
    page = rising._repr_html_()
    assert len(page) < 5000 and "<polyline" in page and "lift &lt;b&gt;" in page and "[m]" in page
    for values in (np.full(3, np.nan), np.array(["a", "b"]), np.ones((2, 3)), np.array([1.0])):
        assert "polyline" not in Trace(("x", "y")[: values.ndim], values, "1", "x")._repr_html_()
