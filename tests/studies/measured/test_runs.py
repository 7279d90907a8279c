"""Measured data in one line each, whatever they hold."""

import numpy as np

from apesim.studies.measured import CHECK, FIT, Measured, MeasuredRun


def test_measured_data_and_a_run_of_them_are_shown_in_a_short_line():
    lift = np.linspace(0.0, 9e-3, 5000)
    run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 50e-3, FIT, lift, {"lift": lift, "pressure_a": lift})
    measured = Measured("data", {"lift": 3e-5}, (run, run, run._replace(role=CHECK)))
    assert repr(run) == "MeasuredRun p040: fit, 5000 samples of lift, pressure_a"
    assert repr(measured) == "Measured: valve, 3 runs (2 fit, 1 check) of lift, pressure_a"
    assert repr(Measured("", {}, ())) == "Measured: valve, 0 runs (none) of nothing"
