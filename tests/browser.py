"""A headless Chromium for tests of pages."""

import base64
import io
import shutil
from contextlib import contextmanager

import numpy as np
import pytest
from PIL import Image

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


def seen_from(page, view, size, frame):
    """The page's picture (size, size, 3), int, of one frame through a camera of `frontal_camera`."""
    camera, T = view
    turn = np.eye(4)
    turn[:3, :3], turn[:3, 3] = T.rotation, T.translation
    place = np.linalg.inv(np.diag([1.0, -1, -1, 1]) @ turn)
    near, far = 10.0, 5000.0
    lens = np.zeros((4, 4))
    lens[0, 0], lens[1, 1], lens[3, 2] = 2 * camera.fx / size, 2 * camera.fy / size, -1
    lens[2, 2:] = -(far + near) / (far - near), -2 * far * near / (far - near)
    fixed = {"matrix": place.T.ravel().tolist(), "projection": lens.T.ravel().tolist()}
    page.evaluate(
        """([fixed, size, frame]) => { const s = studio; s.stage.fixed = fixed; s.stage.size = [size, size];
        s.stillHead = true; s.clock.seek(frame); s.stage.draw(); }""",
        [fixed, size, frame],
    )
    shot = page.evaluate("studio.stage.renderer.domElement.toDataURL()")
    page.evaluate("studio.stage.fixed = null; studio.stage.size = null; studio.stillHead = false; studio.show()")
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(shot.split(",")[1]))).convert("RGB")).astype(int)
