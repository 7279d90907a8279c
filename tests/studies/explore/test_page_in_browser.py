"""The live page in Chromium: it shows what the engine does, at any width and scheme, by pointer and keyboard."""

import pytest

import apesim
from apesim.engine.machine import Machine
from apesim.studies.report.motion import Snapshot, motion_geometry, render_motion
from tests.browser import opened
from tests.studies.report.test_page_in_browser import CONTRAST, MIN_CONTRAST

EXACT, REFUSED = "#status[data-state=exact]", "#status[data-state=bad]"
MOVE = """([key, value]) => { const slider = document.getElementById(`slider-${key.replaceAll(".", "-")}`);
  slider.value = value; slider.dispatchEvent(new Event("input")); }"""
BURST = """async ([key, values]) => { const slider = document.getElementById(`slider-${key}`);
  for (const value of values) { slider.value = value; slider.dispatchEvent(new Event("input"));
    await new Promise((done) => setTimeout(done, 5)); } }"""


def shown(page, label):
    """Number of a tile."""
    tile = page.locator("#facts li", has=page.get_by_text(label, exact=True))
    return float(tile.locator("b").inner_text().split()[0].replace("−", "-"))


def wait_until_exact(page, number):
    """Wait for the exact answer to a request with a number, or a later one."""
    page.wait_for_selector(EXACT, timeout=120_000)
    for _ in range(1200):
        state = page.evaluate("apesimExplore.state()")
        if state["shown"] >= number and state["status"] == "exact":
            return
        page.wait_for_timeout(25)
    raise AssertionError(state)


def test_numbers_follow_the_slider_and_are_those_of_a_run(chromium, address):
    with opened(chromium, address) as (page, complaints):
        wait_until_exact(page, 1)
        page.evaluate(MOVE, ["supply.pressure", 0.8])
        page.evaluate(MOVE, ["speed", 1200])
        wait_until_exact(page, 2)
        run = apesim.run_engine(Machine().with_(supply_pressure="0.8 MPa gauge"), "1200 rpm")
        assert shown(page, "brake torque") == pytest.approx(run["brake_torque"], abs=0.006)
        assert shown(page, "opens at") == pytest.approx(run["valve_open_deg"], abs=0.06)
        assert "0.8 MPa gauge" in page.inner_text("#conditions")
        assert complaints == []


def test_sixty_events_leave_one_answer_behind(chromium, address):
    with opened(chromium, address) as (page, _):
        wait_until_exact(page, 1)
        page.evaluate(BURST, ["speed", list(range(800, 1400, 10))])
        wait_until_exact(page, 2)
        asked = page.evaluate("apesimExplore.state()")
        assert asked["number"] < 61 and asked["shown"] == asked["number"]
        assert page.inner_text("#conditions").startswith("1390 r/min")


def test_a_value_that_cannot_be_is_marked_and_mended(chromium, address):
    with opened(chromium, address) as (page, complaints):
        wait_until_exact(page, 1)
        entry = page.get_by_label("bore, with or without its unit mm")
        entry.fill("9 km")
        entry.press("Enter")
        page.wait_for_selector(REFUSED)
        assert entry.get_attribute("aria-invalid") == "true"
        assert "out of range" in page.inner_text(".slider.bad .fault")
        entry.fill("90")
        entry.press("Enter")
        wait_until_exact(page, 3)
        assert page.locator(".slider.bad").count() == 0 and page.locator("#warnings").is_hidden()
        assert complaints == []


def test_the_keyboard_moves_a_slider_and_the_address_keeps_it(chromium, address):
    with opened(chromium, address) as (page, _):
        wait_until_exact(page, 1)
        page.locator("#slider-speed").focus()
        for _ in range(3):
            page.keyboard.press("ArrowRight")
        wait_until_exact(page, 2)
        assert page.get_by_label("speed, with or without its unit rpm").input_value() == "1030"
        page.reload()
        wait_until_exact(page, 1)
        assert page.inner_text("#conditions").startswith("1030 r/min")
        page.get_by_role("button", name="Reset all").click()
        page.wait_for_selector("#reset:disabled")
        wait_until_exact(page, 2)
        assert page.inner_text("#conditions").startswith("1000 r/min")


@pytest.mark.parametrize(("width", "scheme"), [(390, "light"), (820, "dark"), (1440, "light")])
def test_the_page_fits_any_screen(chromium, address, width, scheme):
    with opened(chromium, address, width=width, scheme=scheme) as (page, complaints):
        wait_until_exact(page, 1)
        assert page.evaluate("document.documentElement.scrollWidth") == width
        assert complaints == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_stands_out_from_what_is_behind_it(chromium, address, scheme):
    with opened(chromium, address, width=1440, scheme=scheme) as (page, _):
        wait_until_exact(page, 1)
        rows = page.evaluate(CONTRAST)
    assert len(rows) > 100
    assert [row for row in rows if row[0] < MIN_CONTRAST] == []


def test_who_wants_no_motion_sees_one_still_after_the_other(chromium, address):
    with opened(chromium, address) as (page, _):
        page.emulate_media(reduced_motion="reduce")
        wait_until_exact(page, 1)
        button, place = page.get_by_role("button", name="Play"), page.locator(".motion-at")
        button.click()
        seen = {place.inner_text()}
        for _ in range(200):
            page.wait_for_timeout(20)
            seen.add(place.inner_text())
            if len(seen) == 3:
                break
    assert seen == {"60°", "75°", "90°"}


def test_the_command_and_the_file_are_handed_on(chromium, address, tmp_path):
    with opened(chromium, address) as (page, _):
        wait_until_exact(page, 1)
        page.evaluate(MOVE, ["engine.bore", 90])
        wait_until_exact(page, 2)
        page.get_by_role("button", name="Copy command").click()
        page.wait_for_selector("#command:visible")
        assert "engine.bore=90 mm" in page.input_value("#command")
        with page.expect_download() as waiting:
            page.get_by_role("button", name="Save machine file").click()
        waiting.value.save_as(tmp_path / "mine.toml")
        assert apesim.Machine.load(tmp_path / "mine.toml").engine.bore == pytest.approx(0.09)


def test_the_valve_is_timed_as_the_ideal_one(chromium, address):
    with opened(chromium, address) as (page, _):
        wait_until_exact(page, 1)
        page.get_by_role("button", name="Open and close as the ideal valve").click()
        wait_until_exact(page, 2)
        assert shown(page, "opens at") == pytest.approx(-5.0, abs=0.11)
        assert shown(page, "closes at") == pytest.approx(70.0, abs=0.11)


def test_an_effect_is_switched_on_and_off(chromium, address):
    with opened(chromium, address) as (page, _):
        wait_until_exact(page, 1)
        before = shown(page, "brake torque")
        page.locator("#effects > summary").click()
        page.get_by_label("switch an effect on").select_option("friction_torque")
        wait_until_exact(page, 2)
        assert shown(page, "brake torque") != before
        page.get_by_role("button", name="switch off").click()
        wait_until_exact(page, 3)
        assert shown(page, "brake torque") == before


MARKS = """(html) => { const box = document.createElement("div"); box.innerHTML = html; return apesimTest(box); }"""
READ = """() => { const numbers = (text) => ((text ?? "").match(/-?[\\d.]+/g) ?? []).map(Number);
  const sizes = (node) => ["transform", "y", "height", "opacity"].flatMap((name) => numbers(node.getAttribute(name)));
  const share = (node) => parseFloat(node.style.getPropertyValue("--high")) || 0;
  const text = (node) => node.dataset.value ? node.textContent : "";
  window.apesimTest = (box) => [...box.querySelectorAll("[data-part],[data-air],[data-value]")].map((node) =>
    [node.dataset.part ?? node.dataset.air ?? node.dataset.value, [...sizes(node), share(node)], text(node)]); }"""
SHOW = """([html, geometry, state]) => { const box = document.createElement("div"); box.innerHTML = html;
  apesimMotion.show(apesimMotion.mount(box, geometry), state); return apesimTest(box); }"""
STATES = "angle", "lift", "pA", "pB", "pCylinder", "pReceiver"


def test_the_script_moves_the_picture_as_python_draws_it(chromium, address):
    machine, highest = Machine().with_(engine_pin_offset="5 mm"), 1.1e6
    first, other = Snapshot(60.0, 2e-3, 5e5, 6e5, 4e5, 1e6), Snapshot(250.0, 7.5e-3, 2e5, 9e5, 1.5e5, 1.05e6)
    given = [
        render_motion(machine, first, highest),
        motion_geometry(machine, highest),
        dict(zip(STATES, other, strict=True)),
    ]
    with opened(chromium, address) as (page, _):
        page.evaluate(READ)
        drawn = page.evaluate(MARKS, render_motion(machine, other, highest))
        moved = page.evaluate(SHOW, given)
    assert len(drawn) == len(moved) > 30
    for (name, sizes, text), (again, moved_sizes, moved_text) in zip(drawn, moved, strict=True):
        assert (again, moved_text) == (name, text)
        assert moved_sizes == pytest.approx(sizes, abs=0.1), name  # sizes and shares are rounded in the picture
