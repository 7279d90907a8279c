"""Archives from Python: described, verified, compared, joined and exported as the commands do it."""

import json
from dataclasses import replace

import numpy as np
import pytest

import apesim
from apesim.archive import ArchiveError, read, write
from apesim.studies.commands.cli import app
from apesim.studies.terminal.console import main_of

SPEEDS = ["600 rpm", "900 rpm", "1200 rpm"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A sweep of three runs: whole, in three parts, and one with another stroke of the engine."""
    made = tmp_path_factory.mktemp("archives")
    longer = apesim.Machine().with_(engine_stroke="80 mm")
    apesim.sweep(apesim.Machine(), SPEEDS, intake="ideal", out=made / "whole.h5")
    apesim.sweep(longer, SPEEDS, intake="ideal", out=made / "longer.h5")
    for number in (1, 2, 3):
        apesim.sweep(apesim.Machine(), SPEEDS, intake="ideal", shard=f"{number}/3", out=made / f"{number}.h5")
    return made


def printed(capsys, *words):
    """Exit code and JSON of a command."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["apesim", *words, "--json"])
        code = main_of(app)
    return code, json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("name", ["info", "verify"])
def test_a_command_prints_what_the_function_returns(folder, capsys, name):
    function = {"info": apesim.describe_archive, "verify": apesim.verify_archive}[name]
    result = function(folder / "whole.h5")
    assert printed(capsys, "archive", name, str(folder / "whole.h5")) == (0, json.loads(json.dumps(result.to_dict())))
    assert result.is_whole and len(repr(result).splitlines()) <= 12 and "<table>" in result._repr_html_()


def test_a_comparison_is_what_the_command_prints(folder, capsys):
    compared = apesim.compare_archives(folder / "whole.h5", folder / "longer.h5")
    code, data = printed(capsys, "archive", "diff", str(folder / "whole.h5"), str(folder / "longer.h5"))
    assert code == 3 and data == json.loads(json.dumps(compared.to_dict()))
    assert not compared.is_same and "engine.stroke" in compared.to_pandas()["name"].tolist()


def test_an_archive_is_the_same_as_itself_and_within_a_tolerance_as_another(folder):
    path = folder / "whole.h5"
    assert apesim.compare_archives(path, path).is_same
    exact, wide = (apesim.compare_archives(path, folder / "longer.h5", rtol=rtol) for rtol in (0.0, 1e9))
    assert "brake_torque_Nm" in {row.name for row in exact.differences} - {row.name for row in wide.differences}
    with pytest.raises(apesim.InputError, match=r"compare_archives\(\): rtol"):
        apesim.compare_archives(path, path, rtol=-1.0)


def test_results_that_differ_by_less_than_the_solvers_error_are_the_same(folder, tmp_path):
    again = read(folder / "whole.h5")
    torque = again.variables["brake_torque_Nm"]
    again.variables["brake_torque_Nm"] = replace(torque, values=torque.values * (1.0 + 1e-7))
    write(again, tmp_path / "again.h5")
    assert apesim.compare_archives(folder / "whole.h5", tmp_path / "again.h5").is_same
    exact = apesim.compare_archives(folder / "whole.h5", tmp_path / "again.h5", rtol=0.0)
    assert {row.name for row in exact.differences} == {"brake_torque_Nm"}
    again.variables["brake_torque_Nm"] = replace(torque, values=torque.values * (1.0 + 1e-3))
    write(again, tmp_path / "other.h5")
    assert not apesim.compare_archives(folder / "whole.h5", tmp_path / "other.h5").is_same


def test_damage_is_a_fault_and_not_raised(folder, tmp_path):
    data = bytearray((folder / "whole.h5").read_bytes())
    data[len(data) // 2] ^= 0xFF
    (tmp_path / "damaged.h5").write_bytes(data)
    verified = apesim.verify_archive(tmp_path / "damaged.h5")
    assert not verified.is_whole and verified.content_sha256 is None and "damaged.h5" in verified.faults[0]


def test_keys_of_another_machine_are_named(folder):
    machine = apesim.Machine().with_(engine_stroke="80 mm")
    for function in (apesim.describe_archive, apesim.verify_archive):
        assert [row["key"] for row in function(folder / "whole.h5", machine=machine).machine_differences] == [
            "engine.stroke"
        ]
        assert not function(folder / "longer.h5", machine=machine).machine_differences


def test_parts_are_joined_and_a_missing_one_is_told(folder, tmp_path):
    parts, out = [folder / f"{number}.h5" for number in (1, 2, 3)], tmp_path / "joined.h5"
    own = apesim.describe_archive(parts[0])
    assert (own["runs"], own["runs_planned"], own.is_whole) == (1, 3, True)  # its own share is whole
    verified = apesim.verify_archive(parts[0])
    assert verified.is_whole and verified.share == verified.to_dict()["share"] == "1/3"
    assert verified.ending.startswith("sound, a share of a sweep: 1/3;")
    assert apesim.merge_archives(parts[:2], out).warnings[-1] == "missing runs: 2 (of 3 planned, counted from 0)"
    with pytest.raises(ArchiveError, match="exists already"):
        apesim.merge_archives(parts, out)
    whole = apesim.merge_archives(parts, out, overwrite=True)
    assert not whole.warnings and whole["runs"] == 3
    assert (apesim.verify_archive(out).ending, apesim.verify_archive(out).share) == ("whole", None)
    for name, variable in read(folder / "whole.h5").variables.items():
        assert np.array_equal(
            variable.values, whole.archive.variables[name].values, equal_nan=variable.kind == "float64"
        )


def test_files_of_text_go_into_a_new_folder(folder, tmp_path):
    paths = apesim.export_archive(folder / "whole.h5", tmp_path / "text")
    assert all(path.is_file() for path in paths) and (tmp_path / "text" / "runs.csv") in paths
    with pytest.raises(ArchiveError, match="is not empty"):
        apesim.export_archive(folder / "whole.h5", tmp_path / "text")


@pytest.mark.parametrize("function", [apesim.describe_archive, apesim.verify_archive])
def test_a_machine_that_no_file_could_say_is_refused(folder, function):
    machine = apesim.Machine()
    wrong = machine._replace(engine=machine.engine._replace(bore=-1.0))
    with pytest.raises(apesim.InputError, match=rf"{function.__name__}\(\): engine.bore"):
        function(folder / "whole.h5", machine=wrong)
