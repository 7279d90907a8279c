"""Progress where standard error is no terminal: a line a stage, and nothing of short or quiet work."""

import pytest

from apesim.studies.execution import progress
from apesim.studies.terminal.console import Console


def work(console):
    with console.stages("explaining") as report:
        for stage in ("calibrating", "fitting candidates"):
            for done in range(3):
                report(stage, done + 1, 3)


@pytest.fixture
def told_at_once(monkeypatch):
    monkeypatch.setattr(progress, "LINES_AFTER", 0.0)


def test_in_a_pipe_each_stage_has_a_line_with_its_time(told_at_once, capsys):
    work(Console())
    lines = capsys.readouterr().err.splitlines()
    stages = [line.split(": ")[0] for line in lines]
    assert stages[-2:] == ["calibrating", "fitting candidates"] and set(stages[:-2]) <= {"explaining"}
    assert all(line.endswith(" s") for line in lines)


def test_a_quiet_console_and_short_work_tell_nothing(monkeypatch, capsys):
    work(Console())
    monkeypatch.setattr(progress, "LINES_AFTER", 0.0)
    work(Console(quiet=True))
    assert capsys.readouterr().err == ""


def test_a_long_stage_is_told_of_while_it_goes_on(told_at_once, monkeypatch, capsys):
    monkeypatch.setattr(progress, "LINE_EVERY", 0.0)
    with Console().progress("sweep") as report:
        report(10, 40)
        report(40, 40)
    first, *_, last = capsys.readouterr().err.splitlines()
    assert first.startswith("sweep: 10 of 40 after") and first.endswith("s left")
    assert last.startswith("sweep: ") and " of " not in last


def test_a_notebook_shows_a_bar_below_the_cell():
    client_of = pytest.importorskip("jupyter_client")
    pytest.importorskip("ipykernel")
    code = (
        "from apesim.studies.execution.progress import show_progress\n"
        "with show_progress(True, 'sweep') as report:\n"
        "    report(1, 4)\n"
        "    report(4, 4)\n"
    )
    manager = client_of.KernelManager(kernel_name="python3")
    manager.start_kernel()
    try:
        client = manager.blocking_client()
        client.start_channels()
        client.wait_for_ready(timeout=60.0)
        shown = []
        client.execute_interactive(code, timeout=60.0, output_hook=shown.append)
    finally:
        manager.shutdown_kernel(now=True)
    pages = [each["content"]["data"]["text/html"] for each in shown if "display_data" in each["msg_type"]]
    assert [each["msg_type"] for each in shown if each["msg_type"] == "error"] == []
    assert pages[0].startswith("<progress></progress> sweep") and 'value="4" max="4"' in pages[-1]
