"""The page's cost with no GPU: start with 76,000 vertices and 52 shapes, bytes and milliseconds a frame.

Needs Chromium and Playwright; a software GPU draws.
"""

import shutil
import sys
import time

import numpy as np
from playwright.sync_api import sync_playwright

from mien.faces import load_face
from mien.mesh import loop_subdivide
from mien.rig import Performance, Rig
from mien.transforms import Transform
from mien.viewer.studio import Studio
from mien.viewer.studio_scene import Shown

FLAGS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist")
FRAMES, DRAWN = 60, 10
"""Of the take; of those that are timed."""

DRAW = f"""(() => {{ for (let i = 0; i < {DRAWN}; i++) {{ studio.clock.seek(i); studio.stage.draw(); }}
studio.stage.renderer.getContext().finish(); }})()"""


def fine_performance() -> Performance:
    """The bundled face with sixteen triangles for each, every shape in use in every frame."""
    rig = load_face().rig
    mesh, S = loop_subdivide(rig.neutral, 2)
    fine = Rig(mesh, np.stack([S @ delta for delta in rig.deltas]), rig.names)
    weights = 0.3 * np.abs(np.sin(0.1 * np.arange(FRAMES)[:, None] + np.arange(len(rig.names))))
    return Performance(fine, weights, Transform.identity(FRAMES), 30.0, np.ones(FRAMES, dtype=bool))


def main() -> None:
    """Print the figures."""
    chromium = shutil.which("chromium")
    if chromium is None:
        sys.exit("no Chromium on this machine (Debian: apt install chromium)")
    performance = fine_performance()
    began = time.perf_counter()
    studio = Studio([Shown("fine", performance)])
    size = len(studio.scene())
    packed = time.perf_counter() - began
    server = studio.open("127.0.0.1")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium, args=list(FLAGS))
        page = browser.new_page(viewport={"width": 900, "height": 640})
        page.goto(server.address)
        page.wait_for_function("window.studio")
        cost = page.evaluate("studio.cost")
        began = time.perf_counter()
        page.evaluate(DRAW)
        drawn = (time.perf_counter() - began) / DRAWN
        browser.close()
    server.shutdown()
    rig = performance.rig
    print(f"{len(rig.neutral.vertices):,} vertices, {len(rig.names)} shapes: {size / 1e6:.0f} MB")
    print(f"packed {packed:.1f} s, decoded {cost['decode_ms'] / 1e3:.2f} s, started {cost['start_ms'] / 1e3:.2f} s")
    print(f"{cost['frame_bytes']} bytes a frame, {1e3 * drawn:.0f} ms to draw one")


if __name__ == "__main__":
    main()
