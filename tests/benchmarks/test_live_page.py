"""Time from a slider to the painted frame of the live page, in Chromium; without one it is skipped by name.

``python -m pytest -n 0 tests/benchmarks/test_live_page.py`` prints the times; nothing here fails on one.
"""

from statistics import median

import numpy as np
import pytest

from tests.browser import opened
from tests.studies.explore.conftest import address  # noqa: F401

SPEEDS = 600, 1000, 1500, 2000, 2400
EVENTS, PAUSE, BURST = 30, 120.0, 60
"""Events at each speed, time between them [ms], and events within a second."""
PAINTED = "apesim:moved-to-painted"
MOVE = """(value) => { const slider = document.getElementById("slider-speed");
  slider.value = value; slider.dispatchEvent(new Event("input")); }"""
RUSH = """async (values) => { const slider = document.getElementById("slider-speed"), begin = performance.now();
  for (const [i, value] of values.entries()) { slider.value = value; slider.dispatchEvent(new Event("input"));
    const rest = (i + 1) * 1000 / values.length - (performance.now() - begin);
    await new Promise((done) => setTimeout(done, Math.max(0, rest))); }
  window.rushEnd = performance.now(); }"""
READ = """(name) => performance.getEntriesByName(name).map((each) => [each.duration, each.detail.processor])"""
LAG = """(name) => { const last = performance.getEntriesByName(name).at(-1);
  return last.startTime + last.duration - window.rushEnd; }"""


def busy(session):
    """Time that the page has kept the processor busy [ms]."""
    metrics = {each["name"]: each["value"] for each in session.send("Performance.getMetrics")["metrics"]}
    return 1e3 * metrics["TaskDuration"]


@pytest.fixture
def page_and_session(chromium, address):  # noqa: F811  # the fixture that is imported
    with opened(chromium, address, width=1440) as (page, _):
        page.wait_for_selector("#status[data-state=exact]", timeout=120_000)
        session = page.context.new_cdp_session(page)
        session.send("Performance.enable")
        yield page, session


def test_slider_to_painted_frame(page_and_session, capsys):
    page, session = page_and_session
    lines = []
    for speed in SPEEDS:
        page.evaluate("performance.clearMeasures()")
        before = busy(session)
        for number in range(EVENTS):
            page.evaluate(MOVE, speed - 10 * number)
            page.wait_for_timeout(PAUSE)
        rows = np.array(page.evaluate(READ, PAINTED))
        used = (busy(session) - before) / len(rows)
        lines.append(
            f"{speed:5d} r/min: median {np.median(rows[:, 0]):4.0f} ms, 95 % {np.quantile(rows[:, 0], 0.95):4.0f} ms; "
            f"processor: server {median(rows[:, 1]):4.1f} ms, page {used:4.1f} ms"
        )
        assert len(rows) >= 0.9 * EVENTS
    with capsys.disabled():
        print("\n" + "\n".join(lines))


def test_events_of_a_second_are_not_queued(page_and_session, capsys):
    page, _ = page_and_session
    page.evaluate("performance.clearMeasures()")
    page.evaluate(RUSH, [800 + 10 * number for number in range(BURST)])
    page.wait_for_selector("#status[data-state=exact]", timeout=120_000)
    rows = page.evaluate(READ, PAINTED)
    with capsys.disabled():
        print(f"\n{BURST} events in 1 s: {len(rows)} frames, lag {page.evaluate(LAG, PAINTED):.0f} ms")
    assert 0 < len(rows) <= BURST + 1
