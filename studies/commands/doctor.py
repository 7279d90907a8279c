"""Command `apesim doctor`."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from apesim.studies.commands.options import Common
from apesim.studies.terminal.console import COMMAND_LINE, DONE, FAULT_OF_OURS, Console

if TYPE_CHECKING:
    from rich.table import Table

    from apesim.studies.run.doctor import SelfTest


def check_installation(
    common: Common,
    compile_all: Annotated[
        bool, typer.Option("--compile", help="First compile every kind of march that the cache does not hold.")
    ] = False,
) -> int:
    """Say what apesim runs on and what its cache holds, and test the embedded machine against known numbers.

    Versions, processor, cores and free memory; the cache folder, its size, which kinds of march are compiled and how
    long that took; then one run of the valve and one of the engine. Exit code 1: a number is off.

    Examples
    --------
    >>> from typer.testing import CliRunner
    >>> from apesim.studies.commands.cli import app
    >>> print(CliRunner().invoke(app, ["doctor", "--set", "engine.bore=90 mm"]).exception)
    command line: --set: has no use here: the known numbers are those of the embedded machine; leave it out
    """
    from apesim.studies.run import doctor

    _refuse_machine(common)
    console = common.console
    compiled_now = _compile_ahead(console) if compile_all else []
    tests = console.run("self-test", lambda: list(doctor.run_self_test()))
    # Described last, so that it counts what the self-test itself has compiled.
    found = doctor.describe_installation()
    passed = all(test.passed for test in tests)
    data = found | {
        "compiled_now": compiled_now,
        "self_test": [test._asdict() for test in tests],
        "allowed_deviation": doctor.ALLOWED,
        "passed": passed,
    }
    verdict = "self-test passed" if passed else "self-test FAILED: do not trust results of this installation"
    allowed = f"{verdict}; a deviation of {doctor.ALLOWED:.2%} is allowed"
    cache = found["cache"]
    where = f"cache: {cache['folder']}, {cache['size_B'] / 1e6:.1f} MB"
    console.result(data, _system_table(found), where, _kinds_table(cache["kinds"]), _test_table(tests), allowed)
    return DONE if passed else FAULT_OF_OURS


def _refuse_machine(common: Common) -> None:
    """Refuse the options that describe a machine."""
    from apesim.quantities import Fault, InputError

    given = {"--machine": common.machine_file, "--set": common.settings}
    wrong = "has no use here: the known numbers are those of the embedded machine"
    if faults := [Fault(COMMAND_LINE, name, wrong, "leave it out") for name, value in given.items() if value]:
        raise InputError(faults)


def _compile_ahead(console: Console) -> list[str]:
    """Compile the kinds of march that the cache does not hold; their names."""
    from apesim.studies.run import doctor

    missing = doctor.missing_kinds()
    if not missing:
        console.message("every kind of march is compiled already")
        return []
    with console.progress("compile") as report:
        for done, kind in enumerate(missing, 1):
            console.run(f"compile the {kind}", doctor.compile_march, kind)
            report(done, len(missing))
    return missing


def _system_table(found: dict[str, Any]) -> "Table":
    """Table of versions, processor and memory."""
    from apesim.studies.terminal.tables import table_of

    memory = found["free_memory_B"]
    rows = [
        *((name, version or "-") for name, version in found["versions"].items()),
        ("platform", found["platform"]),
        ("processor", found["processor"]),
        ("cores", str(found["cores"])),
        ("free memory", "-" if memory is None else f"{memory / 1e9:.1f} GB"),
    ]
    return table_of("installation", ("", "value"), rows, left=(0, 1))


def _kinds_table(kinds: list[dict[str, Any]]) -> "Table":
    """Table of the kinds of march in the cache."""
    from apesim.studies.terminal.tables import table_of

    rows = [
        (
            each["kind"],
            "yes" if each["compiled"] else "no",
            "-" if each["compile_time_s"] is None else f"{each['compile_time_s']:.0f} s",
        )
        for each in kinds
    ]
    return table_of("kinds of march", ("", "compiled", "took last time"), rows)


def _test_table(tests: list["SelfTest"]) -> "Table":
    """Table of the self-test."""
    from apesim.studies.terminal.tables import table_of

    rows = [
        (
            test.name,
            f"{test.computed:.6g}",
            f"{test.reference:.6g}",
            test.unit,
            f"{test.deviation:+.5%}",
            "good" if test.passed else "off",
        )
        for test in tests
    ]
    return table_of("self-test", ("", "computed", "known", "unit", "deviation", ""), rows)
