"""Markers dragged, named and marked as bad in the page, and what the next solve reads of it."""

import json

import numpy as np
import pytest

from browser import browser, page_at
from mien.errors import BadInput
from mien.faces import load_face
from mien.io.gltf import write_performance
from mien.io.markers import read_marker_file, read_markers
from mien.io.markers.marker_edits import read_marker_edits
from mien.markers.attachment_file import labels_off_face, labels_on_face, read_attachment
from mien.viewer.kept.marker_places import STALE, MarkerPlaces, SolvedTake
from mien.viewer.open_files import gather
from mien.viewer.studio import Studio
from studio_things import marked, nodding, write_take


@pytest.fixture(scope="module")
def performance():
    return nodding(13)


@pytest.fixture
def files(tmp_path, performance):
    """A performance, and the take that it might have been solved from; one marker is worn off the face."""
    write_performance(tmp_path / "perf.glb", performance)
    write_take(tmp_path / "take.c3d", performance)
    return tmp_path


@pytest.fixture
def places(files, performance):
    take = read_marker_file(files / "take.c3d", as_filed=True).markers
    return MarkerPlaces(lambda: SolvedTake(take, files / "take.c3d", performance, files / "perf.glb"))


def read(places):
    return json.loads(places.read({}).body)


def save(places, told):
    return places.save(json.dumps(told).encode(), {})


def test_markers_are_found_on_the_skin_of_the_solved_face(places, files, performance):
    save(places, read(places))
    assert labels_off_face(places.attach_file) == ("M7",)
    mesh, labels = performance.rig.neutral, tuple(f"M{m}" for m in range(7))
    found = read_attachment(places.attach_file, labels, len(mesh.faces)).points(mesh)
    assert np.linalg.norm(found - marked().points(mesh)[:7], axis=1).max() < 1.5


def test_a_place_is_found_under_the_weights_that_the_page_shows(places, performance):
    weights, at = performance.weights[8], 3
    vertices = performance.rig.vertices(weights)
    point = marked().points(performance.rig.neutral.with_vertices(vertices))[at]
    asked = {"point": point.tolist(), "weights": weights.tolist()}
    entry = json.loads(places.place(json.dumps(asked).encode(), {}).body)
    assert sorted(entry["corners"]) == sorted(performance.rig.neutral.faces[entry["face"]].tolist())
    np.testing.assert_allclose(np.array(entry["barycentric"]) @ vertices[entry["corners"]], point, atol=1e-3)


def test_what_is_said_is_read_by_the_next_solve(places, files):
    told = read(places)
    told["names"], told["bad"] = {"M2": "chin"}, {"M3": [{"from": 0.1, "to": 0.2}]}
    answer = json.loads(save(places, told).body)
    assert answer["rerun"] == f"mien solve {files / 'take.c3d'} --attach {files / 'perf.attach.json'}"
    take = read_markers(files / "take.c3d")
    assert "chin" in take.labels
    assert np.isnan(take.positions[3:7, 3]).all()
    on_face = labels_on_face(places.attach_file)
    assert set(on_face) | set(labels_off_face(places.attach_file)) == set(take.labels)
    read_attachment(places.attach_file, on_face, len(load_face().rig.neutral.faces))


def test_an_old_revision_is_refused_and_two_of_one_name_too(places, files):
    told = read(places)
    save(places, told)
    answer = save(places, told)
    assert (answer.status, answer.body.decode()) == (409, STALE)
    with pytest.raises(BadInput, match="two markers would be called M1"):
        save(places, read(places) | {"names": {"M0": "M1"}})
    assert not read_marker_edits(files / "take.c3d").names


WHERE = """(m) => { const place = studio.markers.dots.position.clone().fromArray(studio.markers.at.array, 3 * m);
return studio.stage.onScreen(place, 0); }"""


def test_a_marker_is_dragged_named_and_marked_in_the_page(files):
    shown, _ = gather([files / "perf.glb", files / "take.c3d"])
    server = Studio(shown).open("127.0.0.1")
    with browser() as chromium:
        page = page_at(chromium, server.address)
        page.evaluate("studio.markers.ready")
        page.evaluate("studio.stage.draw()")
        x, y = page.evaluate(WHERE, 3)
        before = page.evaluate("studio.markers.state.places.M3")
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 12, y - 10, steps=3)
        page.mouse.up()
        page.wait_for_function("studio.markers.told.startsWith('saved')")
        there = page.evaluate(WHERE, 3)
        np.testing.assert_allclose(there, [x + 12, y - 10], atol=1.5)
        page.fill("#marker-name", "cheek")
        page.keyboard.press("Enter")
        page.evaluate("studio.correct.range = [0.1, 0.2]")
        page.click("#marker-bad")
        page.evaluate("studio.markers.saver.queue")
        assert read_marker_edits(files / "take.c3d").names == {"M3": "cheek"}
        assert json.loads((files / "perf.attach.json").read_text())["cheek"]["face"] != before["face"]
        page.reload()
        page.wait_for_function("window.studio")
        page.evaluate("studio.markers.ready")
        np.testing.assert_allclose(page.evaluate(WHERE, 3), there, atol=0.5)
        assert list(page.evaluate("studio.markers.state.bad")) == ["M3"]
    server.shutdown()
    server.server_close()
