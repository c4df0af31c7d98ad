"""Beside and behind the face in the page: the film that it was tracked in, markers' names, worst regions."""

from dataclasses import replace

import numpy as np
import pytest

from browser import browser, page_at
from mien.camera import Camera
from mien.faces import load_face
from mien.io.gltf import write_performance
from mien.mesh import Scan
from mien.pictures import write_mp4
from mien.transforms import Transform
from mien.viewer.open_files import gather
from mien.viewer.page_files import export_page
from mien.viewer.studio_scene import Film, Shown, is_before, pack_scene
from mien.viewer.worst_regions import RegionMisfit
from studio_things import nodding, write_take

CAMERA = Camera(fx=300, fy=310, cx=150, cy=125, width=320, height=240)
FRAME = 20

ON_SCREEN = """([points, frame]) => { studio.clock.seek(frame); studio.stage.draw();
const { stage, shown } = studio, { position } = stage.camera;
const film = document.querySelector('video.behind').getBoundingClientRect();
const world = (point) => position.clone().fromArray(point).applyMatrix4(shown[0].face.mesh.matrix);
return [points.map((point) => stage.onScreen(world(point), 0)), [film.left, film.top, film.width, film.height]]; }"""
"""Where points of the face are in the window, and where the film is."""

CORNER_ALPHA = """(() => { studio.stage.draw(); const gl = studio.stage.renderer.getContext(), read = new Uint8Array(4);
gl.readPixels(2, 2, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, read); return read[3]; })()"""

MARKER_ON_SCREEN = """(m) => { studio.stage.draw(); const { stage, clouds: [cloud] } = studio;
const place = stage.camera.position.clone().fromArray(cloud.at.array, 3 * m);
return stage.onScreen(place.applyMatrix4(cloud.points.matrix), 0); }"""


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


@pytest.fixture(scope="module")
def tracked():
    """Half a metre before the camera, a little aside."""
    performance = nodding()
    pose = performance.T_world_face
    moved = pose.translation * [1, 0, 1] + [15, -10, -500]
    return replace(performance, T_world_face=Transform(pose.rotation, moved))


def test_a_face_stands_before_the_camera_that_it_was_tracked_by(tracked):
    assert is_before(CAMERA, tracked)
    assert not is_before(CAMERA, nodding())  # of a lab: a metre and a half above the floor


def test_over_the_film_every_vertex_lies_where_the_camera_saw_it(chromium, tracked, tmp_path):
    write_mp4(tmp_path / "film.mp4", [np.full((240, 320, 3), 90, np.uint8)] * 31, 30.0)
    export_page(tmp_path / "page", *_scene(tracked, tmp_path / "film.mp4"))
    page = page_at(chromium, (tmp_path / "page/index.html").as_uri(), 900, 480)
    page.click("#over-film")
    some = np.arange(0, len(tracked.rig.neutral.vertices), 97)
    held = tracked.rig.vertices(tracked.weights[FRAME])[some]
    true = CAMERA.project(tracked.T_world_face[FRAME].apply(held) * [1, -1, -1])
    for size in ((900, 480), (740, 900)):
        page.set_viewport_size({"width": size[0], "height": size[1]})
        page.wait_for_function("([w, h]) => innerWidth === w && innerHeight === h", arg=list(size))
        pixels, (left, top, width, height) = page.evaluate(ON_SCREEN, [held.tolist(), FRAME])
        scale = min(width / CAMERA.width, height / CAMERA.height)
        corner = [left + (width - scale * CAMERA.width) / 2, top + (height - scale * CAMERA.height) / 2]
        np.testing.assert_allclose(pixels, corner + scale * (true + 0.5), atol=0.3)
    assert page.evaluate(CORNER_ALPHA) == 0
    page.get_by_role("button", name="front").click()
    assert page.get_attribute("#over-film", "aria-pressed") == "false"
    assert page.evaluate(CORNER_ALPHA) == 255
    page.close()


def _scene(performance, film):
    films = [Film("film", film, CAMERA)]
    return pack_scene([Shown("perf", performance)], films), films


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    folder = tmp_path_factory.mktemp("solved")
    write_performance(folder / "perf.glb", nodding(5))
    write_take(folder / "take.c3d", nodding(5))
    return folder


def test_a_written_page_names_the_marker_under_the_pointer_and_all_that_are_in_front(chromium, solved, tmp_path):
    shown, _ = gather([solved / "perf.glb", solved / "take.c3d"])
    export_page(tmp_path / "page.html", pack_scene(shown))
    page = page_at(chromium, (tmp_path / "page.html").as_uri())
    at = page.evaluate(MARKER_ON_SCREEN, 3)
    page.mouse.move(at[0] + 3, at[1] - 2)
    assert page.inner_text("#marker-names") == "M3"
    page.mouse.move(5, 5)
    assert page.inner_text("#marker-names") == ""
    page.get_by_role("button", name="names").click()
    page.wait_for_function("document.querySelectorAll('#marker-names span').length > 5")
    page.close()


def test_the_worst_region_stands_first_and_a_click_goes_there(chromium, tmp_path):
    mesh = load_face().rig.neutral
    lips, tip = (mesh.vertices[i] for i in (load_face().regions["mouth"].argmax(), mesh.vertices[:, 2].argmax()))
    fair = RegionMisfit("nose", 0.05, False, tuple(tip.tolist()))
    worst = RegionMisfit("mouth", 0.04, True, tuple(lips.tolist()))
    scans = [Shown(name, Scan(mesh), regions=(one,)) for name, one in (("calm", fair), ("smile", worst))]
    export_page(tmp_path / "page.html", pack_scene(scans))
    page = page_at(chromium, (tmp_path / "page.html").as_uri())
    assert page.locator("#worst button").all_inner_texts() == ["mouth of smile", "nose of calm"]
    assert page.locator("#worst span").all_inner_texts() == ["0.040 !", "0.050"]
    page.locator("#worst button").first.click()
    found = page.evaluate(
        """(at) => { const { stage, shown } = studio; stage.draw();
        const place = stage.camera.position.clone().fromArray(at);
        return stage.onScreen(place.applyMatrix4(shown[1].face.mesh.matrix), 1); }""",
        lips.tolist(),
    )
    box = page.locator("#canvas").bounding_box()
    np.testing.assert_allclose(found, [box["x"] + 0.75 * box["width"], box["y"] + 0.5 * box["height"]], atol=1)
    page.close()
