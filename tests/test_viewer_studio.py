"""The page in a real browser: what its GPU finds against what the library finds."""

from dataclasses import replace

import numpy as np
import pytest

from browser import browser, page_at, seen_from
from lit_things import ball
from mien.faces import load_face
from mien.image_space.constraints import read_constraints
from mien.io.edits_file import edits_beside, edits_from, read_layer
from mien.io.gltf import write_performance
from mien.io.meshes import write_mesh
from mien.mesh import ClosestPoint, Mesh, Scan, vertex_normals
from mien.pictures import Renderer, frontal_camera
from mien.pictures.show import rig_look
from mien.rig.edits import apply_edits
from mien.transforms import Transform
from mien.viewer.gpu_face import refined
from mien.viewer.live_feed import LiveFeed
from mien.viewer.open_files import gather
from mien.viewer.page_files import export_page
from mien.viewer.studio import Studio
from mien.viewer.studio_scene import Shown, pack_scene
from studio_things import nodding

FRAME = 12
SIZE = 480


@pytest.fixture(scope="module")
def performance():
    return nodding()


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


@pytest.fixture(scope="module")
def perf(tmp_path_factory, performance):
    path = tmp_path_factory.mktemp("studio") / "perf.glb"
    write_performance(path, performance)
    return path


@pytest.fixture(scope="module")
def studio(performance, perf):
    return Studio([Shown("perf.glb", performance, perf)])


@pytest.fixture(scope="module")
def page(chromium, studio):
    server = studio.open("127.0.0.1")
    yield page_at(chromium, server.address)
    server.shutdown()
    server.server_close()


def read(page, what, count):
    found = page.evaluate(f"(() => {{ const s = window.studio; s.stage.draw(); return Array.from({what}); }})()")
    return np.array(found).reshape(count, 3)


def test_places_and_normals_are_the_librarys(page, performance):
    page.evaluate(f"studio.clock.seek({FRAME})")
    rig = performance.rig
    coarse = read(page, "s.current.face.read(s.stage.renderer)", len(rig.neutral.vertices))
    expected = rig.vertices(performance.weights[FRAME])
    np.testing.assert_allclose(coarse, expected, atol=5e-3)
    fine = refined(rig.neutral)
    smooth = fine.matrix @ expected
    np.testing.assert_allclose(
        read(page, "s.current.face.read(s.stage.renderer, true)", len(smooth)), smooth, atol=5e-3
    )
    normals = read(page, "s.current.face.readNormals(s.stage.renderer)", len(smooth))
    along = (normals * vertex_normals(smooth, fine.mesh.faces)).sum(axis=1)
    assert np.quantile(along, 0.001) > 0.999


def test_the_picture_is_the_cpus(page, performance):
    """Mean difference over the picture below 2 of 255 levels, 98 of 100 pixels within 12: the shadow's filter, the
    iris and the edges' antialiasing differ."""
    rig = performance.rig
    view = frontal_camera(rig.neutral, SIZE, yaw=0.3)
    drawn = seen_from(page, view, SIZE, FRAME)
    vertices = rig.vertices(performance.weights[FRAME])
    expected = Renderer(rig.neutral, rig_look(rig.neutral)).draw(*view, vertices=vertices).astype(int)
    off = np.abs(drawn - expected).max(axis=2)
    print(f"mean {off.mean():.2f} levels, within 12: {(off <= 12).mean():.4f}")
    assert off.mean() < 2
    assert (off <= 12).mean() > 0.98


def test_time_is_scrubbed_and_played(page, performance):
    box = page.locator("#curves").bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + 20)
    assert page.evaluate("studio.clock.frame") == (len(performance) - 1) // 2
    page.click("#play")
    page.wait_for_function(f"studio.clock.frame > {(len(performance) - 1) // 2 + 3}")
    page.keyboard.press("Space")
    page.click("#play") if page.evaluate("studio.clock.playing") else None
    assert not page.evaluate("studio.clock.playing")


def test_a_slider_moves_its_shape(page):
    page.evaluate("studio.correct.keying.press(false); studio.clock.seek(3)")
    rig = load_face().rig
    k = rig.index("cheekPuff")
    before = read(page, "s.current.face.read(s.stage.renderer)", len(rig.neutral.vertices))
    page.locator('input[data-shape="cheekPuff"]').fill("0.8")
    after = read(page, "s.current.face.read(s.stage.renderer)", len(rig.neutral.vertices))
    np.testing.assert_allclose(after - before, 0.8 * rig.deltas[k], atol=5e-3)
    page.evaluate("studio.correct.keying.press(true); studio.release(); studio.show()")


def saved(page, perf, count):
    """The layer on disk once it holds `count` corrections."""
    page.evaluate("studio.edits.saver.queue")
    assert page.evaluate("studio.edits.told").startswith("saved")
    edits = edits_from(read_layer(edits_beside(perf)), perf)
    assert len(edits) == count
    return edits


def test_corrections_are_kept_and_mean_the_same_to_the_library(page, perf, performance):
    page.evaluate("studio.clock.seek(10)")
    page.locator('input[data-shape="jawOpen"]').fill("0.1")
    page.evaluate("studio.clock.seek(16)")
    page.locator('input[data-shape="jawOpen"]').fill("0.9")
    page.evaluate("studio.edits.mark(0.7, 0.85)")
    edits = saved(page, perf, 3)
    expected = apply_edits(performance, edits)[0]
    assert expected.weights[10, performance.rig.index("jawOpen")] == pytest.approx(0.1, abs=2e-3)
    for frame in (6, 10, 13, 16, 19, 23, 25):
        page.evaluate(f"studio.clock.seek({frame})")
        found = page.evaluate("[Array.from(studio.current.weights), studio.current.face.mesh.matrix.elements]")
        np.testing.assert_allclose(found[0], expected.weights[frame], atol=1e-5)
    page.evaluate("studio.edits.history.undo()")
    saved(page, perf, 2)
    page.evaluate("studio.edits.history.redo()")
    saved(page, perf, 3)


def test_corrections_come_back_and_two_pages_do_not_overwrite_each_other(chromium, studio, perf):
    server = studio.open("127.0.0.1")
    first, second = page_at(chromium, server.address), page_at(chromium, server.address)
    for page in (first, second):
        page.evaluate("studio.ready")
        assert page.evaluate("studio.edits.count") == 3
    first.evaluate("studio.edits.key('mouthPucker', 0.2, 0.5)")
    saved(first, perf, 4)
    second.evaluate("studio.edits.key('mouthPucker', 0.3, 0.5)")
    second.evaluate("studio.edits.saver.queue")
    assert "elsewhere" in second.evaluate("studio.edits.told")
    assert second.evaluate("studio.edits.count") == 4
    for page in (first, second):
        page.close()
    server.shutdown()
    server.server_close()


def test_a_frame_is_a_few_hundred_bytes(page):
    cost = page.evaluate("studio.cost")
    print(cost)
    assert cost["frame_bytes"] <= 1000


def test_a_written_page_needs_no_server(chromium, studio, tmp_path):
    export_page(tmp_path / "page", studio.scene())
    page = page_at(chromium, (tmp_path / "page" / "index.html").as_uri())
    assert page.evaluate("studio.clock.duration") == pytest.approx(1.0)
    page.close()


def test_eyes_of_a_mesh_that_is_not_ours_have_its_own_colours(chromium, tmp_path):
    head, eye = ball(100.0), ball(14.0, (30.0, 0.0, 92.0), rounds=3)
    count = len(head.vertices)
    colors = np.repeat([[0.6, 0.45, 0.4], [0.1, 0.5, 0.2]], [count, len(eye.vertices)], axis=0)
    vertices, faces = np.vstack([head.vertices, eye.vertices]), np.vstack([head.faces, eye.faces + count])
    mesh = Mesh(vertices, faces, colors=colors)
    view = frontal_camera(mesh, SIZE)
    export_page(tmp_path / "page.html", pack_scene([Shown("scan.ply", Scan(mesh))]))
    page = page_at(chromium, (tmp_path / "page.html").as_uri())
    drawn = seen_from(page, view, SIZE, 0)
    page.close()
    expected = Renderer(mesh, rig_look(mesh)).draw(*view).astype(int)
    green = expected[..., 1] > expected[..., 0] + 30
    assert green.sum() > 300
    assert np.abs(drawn - expected)[green].mean() < 8


def test_a_page_of_another_run_says_so(chromium, studio):
    server = studio.open("127.0.0.1")
    page = chromium.new_page()
    page.goto(server.address[:-3] + "abc")
    assert "another run" in page.inner_text("body")
    page.close()
    server.shutdown()
    server.server_close()


def test_two_points_are_picked_on_two_scans(chromium, tmp_path):
    """A click on one scan, then on the other: the file that `mien register --constraints` reads."""
    mesh = load_face().rig.neutral
    for name, shift in (("calm.ply", 0.0), ("smile.ply", 300.0)):
        write_mesh(tmp_path / name, mesh.with_vertices(mesh.vertices + np.array([shift, 0, 0])))
    shown, _ = gather([tmp_path / "calm.ply", tmp_path / "smile.ply"])
    server = Studio(shown).open("127.0.0.1")
    page = page_at(chromium, server.address)
    box = page.locator("#canvas").bounding_box()
    for side in (0.25, 0.75):
        page.mouse.click(box["x"] + side * box["width"], box["y"] + 0.5 * box["height"])
    page.wait_for_function("document.body.innerText.includes('points 1')")
    page.evaluate("studio.correspond.saver.queue")
    pair = read_constraints(tmp_path / "constraints.json")[0]
    assert pair.scans == ("calm.ply", "smile.ply")
    one, two = pair.points[:, 0]
    np.testing.assert_allclose(two - one, [300, 0, 0], atol=0.5)
    assert ClosestPoint(mesh).query(one[None]).distances[0] < 0.5
    page.click("#undo-pair")
    page.wait_for_function("studio.correspond.complete.points.length === 0")
    page.close()
    server.shutdown()
    server.server_close()


def test_a_tracked_face_moves_as_it_is_tracked(chromium):
    rig = load_face().rig
    feed = LiveFeed(lambda frames: "kept")
    server = Studio([Shown("live", rig)], live=feed).open("127.0.0.1")
    page = page_at(chromium, server.address)
    weights = np.zeros(len(rig.names))
    weights[rig.index("jawOpen")] = 0.7
    with feed.stage("fit"):
        feed.show(weights, Transform.identity(), True)
    feed.show(weights, Transform.identity(), True)
    page.wait_for_function("studio.live.frames > 0")
    np.testing.assert_allclose(page.evaluate("Array.from(studio.current.weights)"), weights, atol=1e-6)
    page.wait_for_function("document.querySelector('#stages').textContent.includes('fit')")
    assert page.evaluate("studio.live.bytes") <= 1000
    page.click("#calibrate")
    page.wait_for_function("document.querySelector('#said').textContent === 'calibrated'")
    assert feed.calibrated(weights).max() == 0
    page.close()
    feed.show(weights, Transform.identity(), True)  # nobody looks on any more
    server.shutdown()
    server.server_close()


def test_a_film_is_drawn_and_a_file_written_anew_is_told(chromium, performance, tmp_path):
    few = replace(
        performance,
        weights=performance.weights[:3],
        T_world_face=performance.T_world_face[:3],
        tracked=performance.tracked[:3],
    )
    write_performance(tmp_path / "few.glb", few)
    shown, _ = gather([tmp_path / "few.glb"])
    studio = Studio(shown)
    server = studio.open("127.0.0.1")
    page = page_at(chromium, server.address)
    page.click("#film-out")
    page.wait_for_function("document.querySelector('#told').textContent.includes('few.mp4: 3 frames')")
    assert (tmp_path / "few.mp4").stat().st_size > 1000
    before = studio.scene()
    (tmp_path / "few.glb").write_bytes(b"half of a file")
    assert studio.scene() is before
    write_performance(tmp_path / "few.glb", replace(few, weights=few.weights * 0.5))
    assert studio.scene() != before
    page.wait_for_function("document.querySelector('#told').textContent.includes('written anew')")
    page.close()
    server.shutdown()
    server.server_close()
