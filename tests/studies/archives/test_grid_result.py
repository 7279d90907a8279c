"""Results over a grid: what a call from Python returns is what the command prints and writes."""

import html
import json

import matplotlib.pyplot as plt
import numpy as np
import pytest

from apesim.archive import ArchiveError, read
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.assessment.comparison import assess_valve
from apesim.studies.discharge.effective_area import evaluate_discharge
from apesim.studies.limit.engine_limit_map import find_engine_limit
from apesim.studies.optimise.optimisation import optimise_commands
from apesim.studies.soft_landing.study import find_soft_landing
from apesim.studies.terminal.console import plain
from apesim.studies.timing.correction import correct_timing

TIMING = {
    "target": "-5 deg, 70 deg",
    "speed": "600 rpm, 900 rpm",
    "pressure": "1 MPa gauge",
    "temperature": "287 K, 300 K",
}
STUDIES = {
    "timing": (correct_timing, TIMING, {"speed_rpm": 2, "supply_pressure": 1, "supply_temperature": 2}),
    "assess": (assess_valve, {"speed": "900 rpm, 1200 rpm"}, {"speed_rpm": 2, "valve": 7, "order": 3, "cause": 4}),
}


@pytest.fixture(scope="module", params=STUDIES)
def study(request):
    """Name, call, and sizes of a study that was called from Python."""
    function, arguments, sizes = STUDIES[request.param]
    return request.param, function(Machine(), **arguments), arguments, sizes


def test_a_call_gives_what_the_command_prints_and_writes(study, apesim):
    name, found, arguments, _ = study
    options = [word for key, text in arguments.items() for word in (f"--{key}", text)]
    code, out, _ = apesim("engine", name, *options, "--out", "found.h5", "--no-figures", "--json")
    printed = json.loads(out)
    assert code == 0
    told = plain(found.to_dict())
    assert told == {key: printed[key] for key in told}
    archive = read("found.h5")
    assert archive.provenance["command"].startswith(f"apesim engine {name} ")
    assert found.archive.provenance["command"].startswith(f"apesim.{STUDIES[name][0].__name__}(machine, ")
    for key, variable in archive.variables.items():
        np.testing.assert_array_equal(variable.values, found.archive.variables[key].values, key)


def test_a_result_is_short_named_and_drawn_where_it_is_told(study, tmp_path):
    _, found, _, sizes = study
    assert len(repr(found).splitlines()) < 12 and found.title in repr(found)
    assert html.escape(found.title) in found._repr_html_()
    data = found.to_xarray()
    assert dict(data.sizes) == sizes
    assert data["speed_rpm"].attrs["units"] == "min^-1" and found.traces["speed_rpm"].unit == "r/min"
    assert data["brake_torque"].attrs["units"] == "N m"
    _, ax = plt.subplots()
    assert found.plot(ax) is ax and ax.lines
    plt.close("all")
    path = found.write(tmp_path / "found.h5")
    with pytest.raises(ArchiveError, match="exists already"):
        found.write(path)
    assert found.write(path, overwrite=True) == path


def test_progress_is_told_to_whom_it_is_asked_for(capfd):
    told = []
    assess_valve(Machine(), speed="900 rpm", progress=lambda done, total: told.append((done, total)))
    assert told == [(1, 1)]
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("call", "line"),
    [
        (lambda m: correct_timing(m, speed="600"), "correct_timing(): speed: '600' has no unit; "),
        (lambda m: correct_timing(m, target="-5 deg"), "correct_timing(): target: '-5 deg' is not an opening and a "),
        (lambda m: correct_timing(m, target=["-5 deg", (400.0, "deg")]), "correct_timing(): target: "),
        (lambda m: correct_timing(m, jobs=0), "correct_timing(): jobs: "),
        (lambda m: assess_valve(m, timing="late"), "assess_valve(): timing: 'late' is no timing; write fixed or "),
        (
            lambda m: assess_valve(m.with_(engine_intake="cam")),
            "assess_valve(): engine.intake: is cam, which",
        ),
        (lambda m: find_engine_limit(m, duration="700 deg"), "find_engine_limit(): duration: "),
        (lambda m: optimise_commands(m, goal="fun"), "optimise_commands(): goal: 'fun' is no option; "),
        (lambda m: optimise_commands(m, free="x"), "optimise_commands(): free: 'x' is not the supply pressure"),
        (lambda m: optimise_commands(m, free="supply.pressure=1:2"), "optimise_commands(): free: "),
        (lambda m: find_soft_landing(m, cost=1.0), "find_soft_landing(): cost: "),
        (lambda m: evaluate_discharge(m, [], volume="50 cm^3"), "evaluate_discharge(): files: no discharge test"),
    ],
)
def test_an_argument_is_refused_in_the_words_of_its_option(call, line):
    with pytest.raises(InputError) as caught:
        call(Machine())
    assert str(caught.value).startswith(line)


def test_the_command_names_the_option_and_the_key(apesim):
    for words, line in (
        (("engine", "optimise", "--for", "fun"), "command line: --for: 'fun' is no option; "),
        (
            ("engine", "timing", "--set", "engine.intake=cam"),
            "command line: engine.intake: is cam, which",
        ),
        (("valve", "discharge", "x.csv", "--volume", "1"), "command line: --volume: '1' has no unit"),
        (("engine", "assess", "--speed", "9", "--timing", "x"), "command line: --speed: '9' has no unit"),
    ):
        code, _, err = apesim(*words)
        assert code == 2 and err.startswith(line), err
    assert "command line: --timing: 'x' is no timing" in err
