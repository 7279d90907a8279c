"""The names of the face: each is typed, has an example that runs, and is there for type checkers."""

import doctest
import inspect
import subprocess
import sys

import pytest

import apesim
from tests.links import make_links

OUTSIDE = """
import apesim
run = apesim.run_engine(apesim.Machine(), speed="1000 rpm")
torque: float = run["brake_torque"]
run.traces["lift"].unit.upper()
wrong: int = run.traces["lift"].unit
apesim.run_engine(apesim.Machine(), velocity="1000 rpm")
apesim.no_such_name
"""


def own_examples(name):
    """Examples in the docstring of a name, and in those of its own methods."""
    thing = getattr(apesim, name)
    if inspect.isclass(thing) and issubclass(thing, Exception):
        return []
    found = doctest.DocTestFinder(recurse=inspect.isclass(thing)).find(thing, name)
    return [test for test in found if test.examples]


@pytest.mark.parametrize("name", [name for name in apesim.__all__ if not name.endswith("Error") and name.islower()])
def test_every_function_is_annotated_and_documented(name):
    function = getattr(apesim, name)
    signature = inspect.signature(function)
    assert signature.return_annotation is not inspect.Signature.empty
    for parameter in signature.parameters.values():
        assert parameter.annotation is not inspect.Parameter.empty, parameter
        assert f"\n    {parameter.name} : " in f"\n{function.__doc__}" or parameter.name in function.__doc__
    returned = () if signature.return_annotation in (None, "None") else ("Returns",)
    for section in ("Parameters", *returned, "Raises", "Examples"):
        assert f"{section}\n    ---" in function.__doc__, section


@pytest.mark.parametrize("name", apesim.__all__)
def test_the_examples_of_every_name_run(name):
    tests = own_examples(name)
    thing = getattr(apesim, name)
    assert tests or issubclass(thing, Exception), f"{name} has no example"
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    told = []
    for test in tests:
        runner.run(test, out=told.append)
    assert runner.summarize(verbose=False).failed == 0, "".join(told)


@pytest.mark.slow
def test_a_type_checker_sees_the_face_from_outside(tmp_path):
    """With three errors planted, so that a check of nothing is noticed."""
    make_links(tmp_path / "site")
    (tmp_path / "outside.py").write_text(OUTSIDE)
    code = "import sys; from mypy.main import main; main(args=sys.argv[1:])"
    options = "--no-incremental", "--no-error-summary", "--ignore-missing-imports", "--follow-imports=silent"
    command = [sys.executable, "-P", "-c", code, *options, "outside.py"]
    environment = {"MYPYPATH": str(tmp_path / "site"), "PATH": ""}
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=environment)
    lines = [line.partition(": error: ")[::2] for line in done.stdout.splitlines() if ": error: " in line]
    assert [place for place, _ in lines] == ["outside.py:6", "outside.py:7", "outside.py:8"], done.stdout + done.stderr
    assert '"str"' in lines[0][1] and "velocity" in lines[1][1] and "no_such_name" in lines[2][1]


def test_the_version_is_that_of_the_installation():
    from importlib.metadata import version

    assert apesim.__version__ == version("apesim") and "__version__" in dir(apesim)


def test_a_wrong_name_is_answered_with_the_nearest():
    with pytest.raises(AttributeError, match=r"^apesim has no run_engin; did you mean run_engine or start_engine"):
        _ = apesim.run_engin
    with pytest.raises(AttributeError, match=r"^apesim has no zzz$"):
        _ = apesim.zzz
