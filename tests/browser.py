"""Pages in a browser: Chromium as it is installed, driven by Playwright; without one its tests are skipped by name."""

import re
import shutil
from contextlib import contextmanager

import pytest

NAMES = "chromium", "chromium-browser", "google-chrome"
"""Programs that Playwright can drive, the first that is installed is taken."""
ARGUMENTS = "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update"


@pytest.fixture(scope="module")
def chromium():
    """The browser, one for the tests of a file: while it runs, no other event loop can in its thread."""
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip(f"no browser: none of {', '.join(NAMES)} is installed")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=ARGUMENTS)
        yield browser
        browser.close()


@contextmanager
def opened(browser, address, *, width=1000, scheme="light", scripts=True):
    """A page at an address, as (page, complaints): errors and warnings of its console, requests that leave its host."""
    context = browser.new_context(
        viewport={"width": width, "height": 800}, color_scheme=scheme, java_script_enabled=scripts
    )
    page, complaints = context.new_page(), []
    home = re.match(r"\w+://[^/]*", address)[0]
    page.on("console", lambda told: told.type in ("error", "warning") and complaints.append(told.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda asked: asked.url.startswith((home, "data:")) or complaints.append(asked.url))
    page.goto(address)
    try:
        yield page, complaints
    finally:
        context.close()
