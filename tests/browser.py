"""A headless Chromium for tests of pages."""

import shutil
from contextlib import contextmanager

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist")
UP_MS = 60_000
"""A page is up within this, on a machine that does much else."""


@contextmanager
def browser():
    """Chromium under Playwright; skips, saying so, where either is missing."""
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine (Debian: apt install chromium)")
    playwright = pytest.importorskip("playwright.sync_api", reason="no Playwright (pip install playwright)")
    with playwright.sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        try:
            yield chromium
        finally:
            chromium.close()


def page_at(chromium, address, width=760, height=480):
    """The studio at an address, up; faults of its scripts fail the test."""
    page = chromium.new_page(viewport={"width": width, "height": height})
    page.set_default_timeout(UP_MS)
    faults = []
    page.on("pageerror", lambda fault: faults.append(str(fault)))
    page.on("console", lambda line: faults.append(line.text) if line.type == "error" else None)
    page.goto(address)
    page.wait_for_function("window.studio || document.body.dataset.fault", timeout=UP_MS)
    assert not faults, faults
    return page
