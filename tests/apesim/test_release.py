"""Version and date of the release stand in several files, which say the same."""

import re
import tomllib

from tests.folders import ROOT


def read(name):
    return (ROOT / name).read_text(encoding="utf-8")


def test_version_and_date_are_the_same_everywhere():
    version = tomllib.loads(read("pyproject.toml"))["project"]["version"]
    cited = dict(re.findall(r"^(version|date-released): \"?([^\"\n]+)", read("CITATION.cff"), re.MULTILINE))
    [(latest, date), *_] = re.findall(r"^## (\d+\.\d+\.\d+), (\S+)$", read("CHANGELOG.md"), re.MULTILINE)
    assert (latest, date) == (version, cited["date-released"])
    assert cited["version"] == version


def test_every_release_of_the_changelog_is_dated():
    heads = re.findall(r"^## (.*)$", read("CHANGELOG.md"), re.MULTILINE)
    assert heads
    assert all(re.fullmatch(r"\d+\.\d+\.\d+, \d{4}-\d\d-\d\d|unreleased", head) for head in heads), heads
