"""Folder of caches on each system."""

import sys
from pathlib import Path

import platformdirs.macos
import platformdirs.windows
import pytest

from apesim import cache, kernel
from apesim.compiling import tell_of_compiling
from apesim.studies.terminal.console import Console


@pytest.fixture
def unset(monkeypatch):
    monkeypatch.delenv("APESIM_CACHE_DIR", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)


def test_the_folder_of_caches_is_the_users_own_choice_first(monkeypatch, tmp_path):
    monkeypatch.setenv("APESIM_CACHE_DIR", str(tmp_path))
    assert cache.cache_root() == tmp_path


@pytest.mark.skipif(sys.platform != "linux", reason="the folders of Linux")
def test_on_linux_it_is_where_it_was(unset, monkeypatch, tmp_path):
    assert cache.cache_root() == Path.home() / ".cache" / "apesim"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache.cache_root() == tmp_path / "apesim"


@pytest.mark.parametrize(
    ("system", "end"),
    [(platformdirs.macos.MacOS, "Library/Caches/apesim"), (platformdirs.windows.Windows, "apesim/Cache")],
)
def test_on_other_systems_it_is_where_they_keep_caches(unset, monkeypatch, system, end):
    monkeypatch.setattr(platformdirs, "PlatformDirs", system)
    if system is platformdirs.windows.Windows:
        monkeypatch.setattr(platformdirs.windows, "get_win_folder", lambda _: "/Users/eve/AppData/Local")
    assert cache.cache_root().as_posix().replace("\\", "/").endswith(end)


@pytest.mark.skipif(sys.platform == "win32", reason="homes of POSIX")
def test_a_user_without_a_home_gets_a_temporary_folder(unset, monkeypatch):
    pwd = pytest.importorskip("pwd")

    def unknown(_):
        raise KeyError("uid not found")

    monkeypatch.delenv("HOME", raising=False)
    monkeypatch.setattr(pwd, "getpwuid", unknown)
    monkeypatch.setattr(cache, "_temporary", [])
    with pytest.raises(RuntimeError, match="home"):
        cache.cache_root()
    assert cache.private_folder("units") is None
    kernel.cache_folder.cache_clear()
    with pytest.warns(cache.CacheWarning, match="no home folder: .* set APESIM_CACHE_DIR"):
        assert kernel.cache_folder().parent.name.startswith("apesim-kernels-")
    cache.remove_temporary_folders()
    kernel.cache_folder.cache_clear()


def test_a_command_that_compiles_says_where_nothing_can_be_kept(monkeypatch, tmp_path, capsys):
    (tmp_path / "file").touch()
    monkeypatch.setenv("APESIM_CACHE_DIR", str(tmp_path / "file"))
    monkeypatch.setattr(cache, "_temporary", [])
    cache.temporary_folder("kernels")
    for quiet in (False, True):
        with Console(quiet=quiet).announce_compiling():
            tell_of_compiling("engine")
    cache.remove_temporary_folders()
    [compiling, why] = capsys.readouterr().err.splitlines()
    assert compiling.startswith("compiling") and str(tmp_path / "file") in why and "APESIM_CACHE_DIR" in why
