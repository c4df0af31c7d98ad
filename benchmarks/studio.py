"""What the page costs: start with 76,000 vertices and 52 shapes, bytes, script and drawing a frame; two faces; detail.

Needs Chromium and Playwright. A software GPU draws; `--gpu` lets Chromium use this machine's, and names it.

python benchmarks/studio.py [--gpu] [--detail PAGE]: a folder that `mien detail view --export` wrote.
"""

import argparse
import shutil
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from playwright.sync_api import Browser, Page, sync_playwright

from mien.faces import load_face
from mien.mesh import loop_subdivide
from mien.rig import Performance, Rig
from mien.transforms import Transform
from mien.viewer.page_files import export_page
from mien.viewer.studio import Studio
from mien.viewer.studio_scene import Shown

SOFTWARE = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
HARDWARE = ("--use-angle=default", "--enable-gpu", "--disable-gpu-vsync", "--disable-frame-rate-limit")
FLAGS = ("--no-sandbox", "--ignore-gpu-blocklist")
FRAMES, RATE = 3600, 60.0
"""Of the take: a minute."""
DRAWN = {False: 10, True: 300}
"""Frames that are drawn for a figure, without a GPU and with one."""
WINDOWS = {False: (900, 640), True: (1920, 1080)}
"""Pixels of the page's window."""

RENDERER = """(() => { const gl = studio.stage.renderer.getContext();
const told = gl.getExtension('WEBGL_debug_renderer_info');
return gl.getParameter(told ? told.UNMASKED_RENDERER_WEBGL : gl.RENDERER); })()"""

STUDIO_MS = """(count) => { const { stage, clock } = studio, gl = stage.renderer.getContext(), read = new Uint8Array(4);
const wait = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, read);
const drawn = (n) => { const began = performance.now(); let script = 0;
for (let i = 0; i < n; i++) { const from = performance.now(); clock.set((7 * i + 1) / clock.rate);
script += performance.now() - from; stage.draw(); } wait(); return [script / n, (performance.now() - began) / n]; };
clock.playing = false; drawn(3);
return [...drawn(count), stage.renderer.domElement.width, stage.renderer.domElement.height]; }"""
"""Milliseconds a frame: before it is drawn, and in all, the GPU waited for at the end; size of the picture."""

DETAIL_MS = """(count) => { const gl = detail.renderer.getContext(), read = new Uint8Array(4);
for (const name of ['play', 'fields']) document.getElementById(name).checked = false;
const wait = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, read);
detail.draw(0); wait(); const began = performance.now();
for (let i = 0; i < count; i++) detail.draw(i % detail.D.frames);
wait(); return [(performance.now() - began) / count, gl.drawingBufferWidth, gl.drawingBufferHeight]; }"""

PLAYED_FPS = """(seconds) => new Promise((done) => { studio.timeline.play.press(true); const began = performance.now();
let frames = 0; const step = () => { frames++; const passed = (performance.now() - began) / 1000;
if (passed < seconds) requestAnimationFrame(step); else { studio.timeline.play.press(false); done(frames / passed); } };
requestAnimationFrame(step); })"""


def fine_performance() -> Performance:
    """The bundled face with sixteen triangles for each, every shape in use in every frame."""
    rig = load_face().rig
    mesh, S = loop_subdivide(rig.neutral, 2)
    fine = Rig(mesh, np.stack([S @ delta for delta in rig.deltas]), rig.names)
    weights = 0.3 * np.abs(np.sin(0.05 * np.arange(FRAMES)[:, None] + np.arange(len(rig.names))))
    return Performance(fine, weights, Transform.identity(FRAMES), RATE, np.ones(FRAMES, dtype=bool))


def page_of(browser: Browser, address: str, gpu: bool, up: str = "window.studio") -> Page:
    """A page that is up."""
    width, height = WINDOWS[gpu]
    page = browser.new_page(viewport={"width": width, "height": height})
    page.set_default_timeout(180_000)
    page.goto(address)
    page.wait_for_function(up)
    return page


def told(page: Page, what: str, gpu: bool) -> None:
    """One line: milliseconds a frame, and how often it plays."""
    script, whole, width, height = page.evaluate(STUDIO_MS, DRAWN[gpu])
    fps = page.evaluate(PLAYED_FPS, 5)
    print(f"{what}, {width} x {height}: {whole:.2f} ms a frame, {script:.2f} of it script; plays at {fps:.0f} a second")


def main() -> None:
    """Print the figures."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--gpu", action="store_true")
    words.add_argument("--detail", type=Path)
    asked = words.parse_args()
    chromium = shutil.which("chromium")
    if chromium is None:
        sys.exit("no Chromium on this machine (Debian: apt install chromium)")
    performance = fine_performance()
    began = time.perf_counter()
    studio = Studio([Shown("fine", performance)])
    size = len(studio.scene())
    packed = time.perf_counter() - began
    rig, flags = performance.rig, [*FLAGS, *(HARDWARE if asked.gpu else SOFTWARE)]
    server = studio.open("127.0.0.1")
    with sync_playwright() as driver, TemporaryDirectory() as folder:
        browser = driver.chromium.launch(executable_path=chromium, args=flags)
        page = page_of(browser, server.address, asked.gpu)
        cost = page.evaluate("studio.cost")
        print(f"{len(rig.neutral.vertices):,} vertices, {len(rig.names)} shapes: {size / 1e6:.0f} MB")
        print(f"packed {packed:.1f} s, decoded {cost['decode_ms'] / 1e3:.2f} s, started {cost['start_ms'] / 1e3:.2f} s")
        print(f"{cost['frame_bytes']} bytes a frame; drawn by {page.evaluate(RENDERER)}")
        told(page, "one face", asked.gpu)
        page.close()
        beside = Path(folder) / "two"
        export_page(beside, Studio([Shown("a", performance), Shown("b", performance)]).scene())
        told(page_of(browser, (beside / "index.html").as_uri(), asked.gpu), "two side by side", asked.gpu)
        if asked.detail is not None:
            page = page_of(browser, (asked.detail / "index.html").absolute().as_uri(), asked.gpu, "window.detail")
            spent, width, height = page.evaluate(DETAIL_MS, DRAWN[asked.gpu])
            print(f"detail, {width} x {height}: {spent:.2f} ms a frame")
        browser.close()
    server.shutdown()


if __name__ == "__main__":
    main()
