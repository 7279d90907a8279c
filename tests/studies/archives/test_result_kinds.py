"""Each kind of result comes back from its archive, a pickle and a copy as what it was."""

import base64
import copy
import json
import multiprocessing
import pickle
import re
from dataclasses import replace
from functools import partial

import matplotlib.pyplot as plt
import numpy as np
import pytest

import apesim
from apesim.archive import read
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.results import Scalar, Trace
from apesim.studies.archives.archive_result import ArchiveResult, result_of
from apesim.studies.archives.machines import read_recorded_machine
from apesim.studies.archives.result_kinds import KINDS, SIGNS, kind_of
from apesim.studies.assessment import comparison
from apesim.studies.gap.example_bench import read_example
from apesim.studies.limit.valve_figures import limit_figures
from apesim.studies.optimise import optimisation
from apesim.studies.report.page import render_page, write_content
from apesim.studies.report.pages.kinds import BARE, PAGES
from tests.archive_samples import VERSION_1, VERSION_2, VERSION_2_SWEEP
from tests.folders import SAMPLES
from tests.studies.drawing.figure_faults import faults_of, watch_figures

VERSION_1_MAP = SAMPLES / "version_1_map.h5"
PLACE = {"pressure": "1 MPa gauge", "temperature": "287 K"}
STUDIES = {
    "Sweep": partial(apesim.sweep, speed="900 rpm, 1200 rpm", intake=["cam", "ideal"]),
    "ValveMap": partial(apesim.map_valve, pressure="0.6:1.0:0.4 MPa gauge", temperature="280 K, 300 K"),
    "ValveLimit": partial(apesim.find_valve_limit, duty=0.5, **PLACE),
    "EngineLimitMap": partial(apesim.find_engine_limit, duration="75 deg", **PLACE),
    "CorrectedTiming": partial(
        apesim.correct_timing, speed="777 rpm, 900 rpm", pressure="1 MPa gauge", temperature="280 K, 300 K"
    ),
    "OptimalCommands": partial(apesim.optimise_commands, speed="900 rpm", goal="both"),
    "ValveAssessment": partial(apesim.assess_valve, speed="900 rpm"),
    "StartRun": partial(apesim.start_engine, angle="30 deg"),
    "StartMap": partial(apesim.start_engine, angle="all", vary={"engine.cylinders": "1, 2"}),
    "TransientRun": partial(apesim.run_transient, duration="0.3 s", angle="30 deg"),
    "SoftLanding": partial(apesim.find_soft_landing, pressure="1 MPa gauge", solenoids="b"),
}
OTHERS = {
    "run_engine": partial(apesim.run_engine, Machine(), "1000 rpm"),
    "run_many": partial(apesim.run_many, [Machine()], "1000 rpm"),
    "run_valve": partial(apesim.run_valve, Machine()),
    "check_measured": lambda: apesim.check_measured(Machine(), read_example()),
    "fit": lambda: apesim.fit(read_example(), ["valve.viscous_friction"]),
    "list_effects": apesim.list_effects,
    "read_measured": read_example,
    "describe_archive": partial(apesim.describe_archive, VERSION_2),
    "verify_archive": partial(apesim.verify_archive, VERSION_2),
    "compare_archives": partial(apesim.compare_archives, VERSION_1, VERSION_2),
    "read_archive": partial(apesim.read_archive, VERSION_2_SWEEP),
}
"""Calls whose results are no study's. Explanations and isolabilities are copied where the tests have them already."""
COPIES = {"pickle": lambda result: pickle.loads(pickle.dumps(result)), "copy": copy.copy, "deepcopy": copy.deepcopy}
FOUND = {}


def found(name):
    """Result of a study, computed once."""
    if name not in FOUND:
        FOUND[name] = STUDIES[name](Machine())
    return FOUND[name]


def plain(data):
    """Nested data in which NaN equals NaN."""
    if isinstance(data, dict):
        return {key: plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple | np.ndarray):
        return [plain(value) for value in data]
    return "NaN" if isinstance(data, float) and data != data else data


def test_every_kind_of_archive_is_tried():
    assert {path.partition(":")[2] for path in KINDS.values()} == set(STUDIES) and set(SIGNS) == set(KINDS) == set(
        PAGES
    )


@pytest.mark.parametrize("name", STUDIES)
def test_an_archive_without_a_kind_is_known_by_what_it_holds(name):
    archive = found(name).archive
    kind = archive.provenance["kind"]
    assert KINDS[kind].endswith(f":{name}")
    bare = {key: text for key, text in archive.provenance.items() if key != "kind"}
    assert kind_of(archive.variables, bare) == kind
    assert type(result_of(replace(archive, provenance=bare))).__name__ == name


@pytest.mark.parametrize(("path", "kind"), [(VERSION_1_MAP, "valve map"), (VERSION_2_SWEEP, "engine sweep")])
def test_the_kind_of_an_old_archive_is_told(apesim, path, kind):
    assert "kind" not in read(path).provenance
    assert json.loads(apesim("archive", "info", str(path), "--json")[1])["kind"] == kind
    assert f"kind          {kind}\n" in apesim("archive", "info", str(path))[1]


@pytest.mark.parametrize("name", ["ValveLimit", "EngineLimitMap", "OptimalCommands", "SoftLanding"])
def test_figures_of_studies_that_take_long_are_without_fault(name, monkeypatch, tmp_path):
    result, watched = found(name), watch_figures(monkeypatch)
    if name == "ValveLimit":
        limit_figures(result.archive, Machine().ambient.pressure, tmp_path)
    else:
        result.draw(tmp_path)
    assert watched and not {figure: faults for figure, faults in watched.items() if faults}
    for what in {"OptimalCommands": optimisation.PLOTS, "ValveLimit": ("limit_hz", "limit_rpm")}.get(name, (None,)):
        axes = result.plot(**{"what": what} if what else {})
        assert not faults_of(axes.figure)
        plt.close(axes.figure)


def test_a_kind_of_a_later_version_comes_back_bare_and_says_so():
    archive = found("ValveMap").archive
    later = result_of(replace(archive, provenance=archive.provenance | {"kind": "valve song"}))
    assert type(later) is ArchiveResult and "does not know: 'valve song'" in later.warnings[-1]


@pytest.mark.parametrize("name", STUDIES)
def test_a_result_comes_back_from_its_archive_as_what_it_was(name, tmp_path):
    result = found(name)
    again = apesim.read_archive(result.write(tmp_path / "result.h5"))
    assert type(again).__name__ == name and again.warnings == result.warnings and again.failed == result.failed
    assert again == result and set(result) - set(again) == {"wall_time"} & set(result)
    assert list(again.traces) == list(result.traces) and repr(again).splitlines()[0] == repr(result).splitlines()[0]
    drawn = [[line.get_xydata() for line in one.plot().lines] for one in (result, again)]
    assert all(np.array_equal(*pair, equal_nan=True) for pair in zip(*drawn, strict=True))
    plt.close("all")
    assert plain(again.to_dict()) == plain(result.to_dict())
    if name == "SoftLanding":
        assert {path.suffix for path in again.draw(tmp_path / "figures")} == {".png", ".pdf"}
    again.write(tmp_path / "again.h5")
    assert apesim.compare_archives(tmp_path / "result.h5", tmp_path / "again.h5").is_same


@pytest.mark.parametrize("name", STUDIES)
def test_every_kind_has_a_page_of_its_own_the_same_each_time(name):
    result = found(name)
    content, odd = write_content(result, result.archive.provenance["kind"])
    assert odd == [] and content.sections and content.title != BARE(result).title
    page = render_page(result)
    assert page == render_page(result_of(result.archive)) and len(page) < 300_000 + 12 * count_samples(page)


def count_samples(page):
    """Numbers that a page shows: the arrays that its figures take."""
    arrays = json.loads(re.search(r'id="data">(.*?)</script>', page)[1])["arrays"]
    return sum(len(base64.b64decode(text)) // int(kind[1]) for each in arrays for kind, text in each.items())


def test_an_archive_of_any_kind_has_a_page():
    paths = [VERSION_1, VERSION_2, VERSION_2_SWEEP, VERSION_1_MAP]
    for archive in [read(path) for path in paths] + [found(name).archive for name in STUDIES]:
        few = dict(list(archive.variables.items())[: len(archive.variables) // 2])
        for changed in (archive, replace(archive, machine="[engine"), replace(archive, variables=few)):
            page = render_page(result_of(changed))
            assert page.startswith("<!doctype html>") and page.endswith("</html>") and '="nan"' not in page


@pytest.mark.parametrize(
    ("name", "plots"), [("ValveAssessment", comparison.PLOTS), ("OptimalCommands", optimisation.PLOTS)]
)
def test_what_a_study_says_it_draws_it_draws(name, plots):
    labels = [found(name).plot(what=what).get_ylabel() for what in plots]
    assert labels == [label for _, label in plots.values()]
    with pytest.raises(InputError, match="there is no plot of noise; give one of"):
        found(name).plot(what="noise")
    plt.close("all")


@pytest.mark.parametrize("way", COPIES)
@pytest.mark.parametrize("name", STUDIES)
def test_the_result_of_a_study_equals_its_copies(name, way):
    result, copied = found(name), COPIES[way](found(name))
    assert type(copied) is type(result) and copied == result and (copied != result) is False
    with pytest.raises(TypeError):
        copied.scalars["more"] = Scalar(1.0)
    with pytest.raises(ValueError):
        next(iter(copied.traces.values())).values[...] = 0.0
    assert plain(getattr(copied, "to_dict", dict)()) == plain(getattr(result, "to_dict", dict)())


@pytest.mark.parametrize("name", OTHERS)
def test_any_other_result_can_be_pickled_and_copied(name):
    result = OTHERS[name]()
    for way in COPIES.values():
        copied = way(result)
        assert type(copied) is type(result) and repr(copied) == repr(result)
        if isinstance(result, apesim.results.Result):
            assert copied == result


def test_results_differ_by_any_number_trace_or_text():
    result = found("ValveMap")
    scalars, traces = dict(result.scalars), dict(result.traces)
    others = [
        replace(result, scalars=scalars | {"runs": Scalar(9, "1", "runs")}),
        replace(result, scalars=scalars | {"more": Scalar(9.0)}),
        replace(result, traces=traces | {"opening_delay": Trace(("run",), np.zeros(4), "s")}),
        replace(result, traces={}),
        replace(result, machine=""),
        replace(result, warnings=("one",)),
        ArchiveResult.of(result.archive),
    ]
    assert all(other != result for other in others)
    assert replace(result, scalars=scalars | {"wall_time": Scalar(9.0, "s", "computing time")}) == result
    assert result != 1 and result != {}


def test_an_archive_that_only_looks_like_one_of_a_kind_comes_back_bare_and_says_so(tmp_path):
    for name in STUDIES:
        archive = found(name).archive
        less = {
            key: value for key, value in archive.variables.items() if not key.startswith(("opening_kept", "front_"))
        }
        for changed in (
            replace(archive, machine="[engine"),
            replace(archive, variables=less | {"speed_rpm": archive.variables["run"]}),
            replace(archive, provenance=archive.provenance | {"interpolation_error_rad": "[", "cost_s": "x"}),
        ):
            result = result_of(changed)
            assert type(result).__name__ == name or "not read as what it seems to be" in result.warnings[-1]
    bare = result_of(replace(found("SoftLanding").archive, machine="[engine"))
    assert type(bare) is ArchiveResult and "machine of the archive" in bare.warnings[-1]


def test_the_machine_of_an_archive_opens_no_file_and_runs_no_code(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text("raise SystemExit")
    (tmp_path / "curve.csv").write_text("time [ms],opening [-]\n0,0\n1,1\n")
    text = '[effects]\nfiles = ["mine.py"]\n[effects.mine]\nforce = "1 N"\n[effects.ring_leakage]\narea = "0.1 mm^2"\n'
    assert read_recorded_machine(text) == Machine().with_(effects_ring_leakage_area="0.1 mm^2")
    with pytest.raises(apesim.InputError, match=r"valve\.solenoid\.opening_curve: names a file"):
        read_recorded_machine('[valve.solenoid]\nopening_curve = "curve.csv"\n')
    with pytest.raises(InputError, match=r"cylinder\[2\].valve.solenoid.opening_curve: names a file"):
        read_recorded_machine('[[cylinder]]\n[[cylinder]]\nvalve.solenoid.opening_curve = "curve.csv"\n')


@pytest.mark.parametrize("way", COPIES)
def test_a_machine_equals_its_copies(way, tmp_path):
    curve = np.array([[0.0, 0.0], [1e-3, 0.4], [2e-3, 1.0]])
    rich = Machine().with_(
        valve_solenoid_opening_curve=curve,
        effects_ring_leakage_area="0.1 mm^2",
        supply_control_pressure="0.8 MPa gauge",
    )
    outside = (
        Machine().with_effects("docs/examples/data/tapered_bore.py").with_(effects_tapered_bore_friction="60 N s/m")
    )
    machines = [Machine(), rich, outside, rich.with_(engine_bore="90 mm")]
    for machine in machines:
        copied = COPIES[way](machine)
        assert copied == machine and (copied != machine) is False and hash(copied) == hash(machine)
    for machine in machines[:2]:
        (tmp_path / "machine.toml").write_text(machine.to_toml(), encoding="utf-8")
        loaded = Machine.load(tmp_path / "machine.toml")
        assert loaded == machine and {loaded: 1}[machine] == 1
    assert len(set(machines)) == 4 and rich != rich.with_(valve_solenoid_opening_curve=curve * [2.0, 1.0])
    assert Machine() != tuple(Machine()) and Machine() != 1 and Machine() is not None


def test_errors_can_be_pickled():
    errors = []
    for call in (lambda: apesim.run_engine(Machine(), 600), lambda: apesim.read_archive("no.h5")):
        with pytest.raises((apesim.InputError, apesim.ArchiveError)) as caught:
            call()
        errors.append(caught.value)
    errors.append(apesim.InputError(fault for fault in errors[0].faults))
    errors.append(apesim.NotConverged("a point", "does not repeat", "change it", found("ValveMap")))
    for error in errors:
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is type(error) and str(again) == str(error)
    assert again.result == found("ValveMap")


def test_results_come_back_from_other_processes():
    machines = [Machine(), Machine().with_(supply_pressure="0.8 MPa gauge")]
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        results = pool.map(apesim.run_valve, machines)
    assert results == [apesim.run_valve(machine) for machine in machines]
