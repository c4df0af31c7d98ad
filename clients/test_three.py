"""three.js shows what was written, in headless Chromium: vertices, normals, names, the clip's length, lit pixels."""

import functools
import http.server
import shutil
import threading

import numpy as np
import pytest
from face import CACHE, FRAMES, HERE, TOLERANCE_MM, Shown, off_mm, performance, run, turned_deg

from browser import browser
from mien.io.gltf import write_performance

THREE = "three@0.170.0"


@pytest.fixture(scope="module")
def modules():
    """three.js, installed once in the user's cache."""
    home = CACHE / THREE.replace("@", "-")
    if not (home / "node_modules/three").is_dir():
        home.mkdir(parents=True, exist_ok=True)
        run("npm", "install", "--silent", "--prefix", home, THREE)
    return home / "node_modules/three"


def test_three_js_shows_every_vertex_where_it_is(tmp_path, modules):
    play = performance()
    write_performance(tmp_path / "face.glb", play)
    (tmp_path / "three").symlink_to(modules)
    shutil.copy(HERE / "three_frames.html", tmp_path / "index.html")
    handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=str(tmp_path))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with browser() as chromium:
        page = chromium.new_page()
        page.goto(f"http://127.0.0.1:{server.server_port}/index.html")
        page.wait_for_function("window.ready === true")
        read = page.evaluate("seconds => window.evaluate(seconds)", [frame / play.rate for frame in FRAMES])
    server.shutdown()
    server.server_close()
    points, normals = (np.array(read[key]).reshape(len(FRAMES), -1, 3) for key in ("points", "normals"))
    shown = Shown(points * 1000, normals, tuple(read["names"]), play.rate, (0, 0))
    turned = turned_deg(shown, play)
    off = off_mm(shown, play)
    print(f"three.js: {off:.1e} mm, normals {np.median(turned):.2f} degrees (95 %: {np.quantile(turned, 0.95):.2f})")
    assert off < TOLERANCE_MM
    assert shown.names == play.rig.names
    assert read["duration"] == pytest.approx((len(play) - 1) / play.rate, abs=1e-5)
    assert 0.02 < read["lit"] < 0.9
    assert np.quantile(turned, 0.95) < 15
