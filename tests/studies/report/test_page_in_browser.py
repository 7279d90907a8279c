"""Pages in Chromium: what they say under the pointer and the keyboard, and how they look at any width and scheme."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from apesim.studies.report.figures.labels import find_shown_unit
from apesim.studies.report.page import render_page
from tests.browser import opened
from tests.studies.report.conftest import STUDIES, found

MIN_CONTRAST = 4.5
"""Contrast of text that WCAG 2.1 asks for at level AA."""
CONTRAST = Path(__file__).with_name("contrast.js").read_text(encoding="utf-8")


def number_of(text):
    return float(text.replace("−", "-"))


def figure_of(page, title):
    return page.locator("figure", has=page.get_by_role("heading", name=title, exact=True)).first


@pytest.mark.parametrize("name", STUDIES)
def test_a_page_asks_for_nothing_and_fits_any_screen(chromium, pages, name):
    for width, scheme in ((390, "light"), (820, "dark"), (1440, "light")):
        with opened(chromium, pages(name), width=width, scheme=scheme) as (page, complaints):
            page.wait_for_selector("figure.mounted, figure.map")
            assert page.evaluate("document.documentElement.scrollWidth") == width
        assert complaints == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_stands_out_from_what_is_behind_it(chromium, pages, scheme):
    with opened(chromium, pages("sweep"), scheme=scheme) as (page, _):
        page.wait_for_selector("figure.mounted")
        rows = page.evaluate(CONTRAST)
        assert len(rows) > 200
        assert [row for row in rows if row[0] < MIN_CONTRAST] == []


def test_values_under_the_pointer_are_those_of_the_archive(chromium, pages):
    archive, generator = found("sweep").archive, np.random.default_rng(58)
    speeds = archive.variables["speed_rpm"].values
    with opened(chromium, pages("sweep")) as (page, _):
        for title, name in (("Brake torque", "brake_torque_Nm"), ("Opening of the valve", "valve_open_deg")):
            figure, variable = figure_of(page, title), archive.variables[name]
            plot = figure.locator(".u-over")
            plot.scroll_into_view_if_needed()
            box = plot.bounding_box()
            for share in generator.uniform(0.01, 0.99, 10):
                page.mouse.move(box["x"] + share * box["width"], box["y"] + 0.5 * box["height"])
                speed = number_of(re.search(r"speed (\S+)", figure.locator(".place").inner_text())[1])
                told = [number_of(text) for text in figure.locator(".legend b").all_inner_texts()]
                own = variable.values[speeds == speed] * find_shown_unit(variable.unit)[0]
                assert np.allclose(told, own, rtol=1e-4) and len(told) == 4


def test_points_of_a_loop_are_found_by_distance(chromium, pages):
    archive = found("sweep").archive
    volume, pressure = (archive.variables[f"cylinder_{name}"].values for name in ("volume", "pressure"))
    with opened(chromium, pages("sweep")) as (page, _):
        figure = figure_of(page, "p–V diagram")
        dot, plot = figure.locator("circle"), figure.locator(".plot")
        plot.focus()
        for key in ("ArrowRight", "ArrowRight", "PageUp", "ArrowDown", "End"):
            page.keyboard.press(key)
            x = number_of(re.search(r"volume (\S+)", figure.locator(".place").inner_text())[1])
            y = number_of("".join(figure.locator(".legend b").all_inner_texts()))
            away = np.abs(volume * 1e6 / x - 1.0) + np.abs(pressure * 1e-6 / y - 1.0)
            assert away.min() < 2e-4
        page.keyboard.press("Home")
        page.keyboard.press("Shift+ArrowRight")
        there = dot.bounding_box()
        page.keyboard.press("End")
        assert dot.bounding_box() != there
        middle = [there[side] + 0.5 * there[size] for side, size in (("x", "width"), ("y", "height"))]
        page.mouse.move(*middle)
        now = dot.bounding_box()
        assert abs(now["x"] - there["x"]) < 3.0 and abs(now["y"] - there["y"]) < 3.0


def test_a_map_says_its_cells_under_pointer_and_keys(chromium, pages):
    archive = found("map").archive
    with opened(chromium, pages("map")) as (page, _):
        figure = figure_of(page, "Opening delay")
        picture = figure.locator("svg")
        picture.focus()
        values = archive.variables["opening_delay_s"].values.reshape(3, 3)
        for key, (pressure, temperature) in (("ArrowRight", (0, 0)), ("ArrowRight", (1, 0)), ("ArrowUp", (1, 1))):
            page.keyboard.press(key)
            told = number_of(re.search(r"opening delay (\S+) ms", figure.locator("output").inner_text())[1])
            assert told == pytest.approx(1e3 * values[pressure, temperature], rel=1e-4)
        cell = figure.locator(".cells rect").first.bounding_box()
        page.mouse.move(cell["x"] + 9, cell["y"] + 9)
        assert figure.locator(".mark").get_attribute("visibility") == "visible"


def test_a_slider_shows_another_frame_in_curves_and_animation(chromium, pages):
    archive = found("sweep").archive
    speeds, lift = (archive.variables[name].values for name in ("speed_rpm", "lift"))
    with opened(chromium, pages("sweep")) as (page, complaints):
        figure, slider = figure_of(page, "Lift of the intake"), page.get_by_label("speed", exact=True)
        slider.focus()
        page.keyboard.press("End")
        assert slider.locator("xpath=following-sibling::output").inner_text() == "1400 r/min"
        figure.locator(".plot").focus()
        page.keyboard.press("Home")
        for _ in range(4):
            page.keyboard.press("Shift+ArrowRight")
        angle = number_of(re.search(r"crank angle (\S+)", figure.locator(".place").inner_text())[1])
        place = np.flatnonzero((archive.variables["crank_angle"].values - angle) % 360.0 == 0.0)
        told = [number_of(text) for text in figure.locator(".legend b").all_inner_texts()]
        assert np.allclose(told, 1e3 * lift[speeds == 1400.0][:, place[0]], rtol=1e-4)
        at = page.locator(".motion-at").inner_text()
        assert number_of(at.removesuffix("°")) == pytest.approx(angle, abs=0.1)
        page.locator(".motion-slider").focus()
        page.keyboard.press("ArrowRight")
        marked = figure_of(page, "p–V diagram").locator(".legend b").all_inner_texts()
        assert [bool(text) for text in marked] == [
            False,
            True,
            False,
            False,
        ]  # of the EPV with corrected timing, as it moves
        page.get_by_role("button", name="Play").click()
        page.wait_for_function("at => document.querySelector('.motion-at').textContent !== at", arg=at)
        assert complaints == []


def test_a_name_switches_its_line_off_and_focus_is_seen(chromium, pages):
    with opened(chromium, pages("sweep")) as (page, _):
        figure = figure_of(page, "Brake torque")
        button = figure.get_by_role("button").first
        button.focus()
        page.keyboard.press("Space")
        assert button.get_attribute("aria-pressed") == "false"
        page.keyboard.press("Shift+Tab")
        outline = page.evaluate("getComputedStyle(document.activeElement).outline")
        assert "solid 3px" in outline


def test_colours_follow_the_scheme(chromium, pages):
    with opened(chromium, pages("transient")) as (page, _):
        page.wait_for_selector("figure.mounted canvas")
        pictures = []
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            page.wait_for_timeout(100)
            pictures.append(page.locator("canvas").first.evaluate("canvas => canvas.toDataURL()"))
        assert pictures[0] != pictures[1]


def test_without_scripts_the_pictures_stand(chromium, pages):
    with opened(chromium, pages("sweep"), width=390, scripts=False) as (page, complaints):
        drawn = page.locator("figure .picture svg")
        assert drawn.count() > 15 and drawn.first.is_visible()
        assert not page.locator(".hint").is_visible() and complaints == []


def test_a_page_prints_its_pictures_on_a4(chromium, pages):
    with opened(chromium, pages("sweep")) as (page, _):
        page.wait_for_selector("figure.mounted")
        page.emulate_media(media="print")
        assert page.locator("figure .picture").first.is_visible() and not page.locator(".live").first.is_visible()
        printed = page.pdf(prefer_css_page_size=True)
    sizes = {
        tuple(round(float(size)) for size in found)
        for found in re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", printed)
    }
    assert sizes <= {(595, 842), (596, 842), (595, 843)} and sizes


def test_a_hostile_name_stays_text(chromium, pages):
    result = found("map")
    bad = "</script><img src=x onerror=alert(1)><script>alert(2)</script>"
    about = result.archive.provenance | {"command": bad, bad[:40]: "x"}
    variables = {name: replace(variable, description=bad) for name, variable in result.archive.variables.items()}
    variables["control_air_kg"] = replace(variables["control_air_kg"], unit="</script x=")  # within the data of figures
    archive = replace(result.archive, provenance=about, variables=variables)
    text = render_page(replace(result, archive=archive, warnings=(bad,)))
    with opened(chromium, pages("hostile", text)) as (page, complaints):
        page.wait_for_selector("figure.mounted")
        assert page.locator("img").count() == 0 and complaints == []
        assert page.locator(".warnings p").first.inner_text() == bad
