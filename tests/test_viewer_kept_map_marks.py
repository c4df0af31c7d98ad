"""Landmarks, pins and masks that the page makes on a capture's map, as `mien rig --corrections` reads them."""

import json

import numpy as np
import pytest

from blendshape_faces import LAYOUT, face_landmarks, face_map
from browser import browser, page_at
from mien.blendshapes.corrections import read_corrections
from mien.blendshapes.map_file import write_map
from mien.errors import BadInput
from mien.viewer.kept import map_marks
from mien.viewer.kept.map_marks import FILE, STALE, MapMarks
from mien.viewer.open_files import gather
from mien.viewer.studio import Studio


@pytest.fixture
def captures(tmp_path, monkeypatch):
    """A folder with a map, and true landmarks for it."""
    write_map(tmp_path / "smile.exr", face_map())
    monkeypatch.setattr(map_marks, "landmarks_on_map", lambda _: face_landmarks())
    return tmp_path


def read(marks):
    return json.loads(marks.read({"map": "smile.exr"}).body)


def save(marks, told):
    return marks.save(json.dumps(told).encode(), {"map": "smile.exr"})


def test_what_is_said_of_other_captures_stays(captures):
    (captures / FILE).write_text(json.dumps({"frown": {"landmarks": {"61": [1, 2]}}}))
    marks = MapMarks([captures / "smile.exr"])
    told = read(marks) | {"landmarks": {"61": [150, 200], "13": None}, "pins": {"mole": [140.5, 120]}}
    assert json.loads(save(marks, told).body)["rerun"] == f"mien rig {captures} --corrections {captures / FILE}"
    found = read_corrections(captures / FILE)
    assert found["smile"].landmarks == {61: (150.0, 200.0), 13: None}
    assert found["smile"].pins == {"mole": (140.5, 120.0)}
    assert found["frown"].landmarks == {61: (1.0, 2.0)}
    save(marks, read(marks) | {"landmarks": {}, "pins": {}})
    assert set(read_corrections(captures / FILE)) == {"frown"}


def test_what_cannot_be_read_is_refused_and_the_file_left(captures):
    marks = MapMarks([captures / "smile.exr"])
    save(marks, read(marks) | {"pins": {"mole": [140, 120]}})
    before = (captures / FILE).read_text()
    with pytest.raises((BadInput, ValueError), match="there are 478"):
        save(marks, read(marks) | {"landmarks": {"900": [1, 2]}})
    assert save(marks, read(marks) | {"revision": 0}).body.decode() == STALE
    assert (captures / FILE).read_text() == before
    with pytest.raises(BadInput, match="shows none of that name"):
        marks.read({"map": "../smile.exr"})


NEAREST = """(place) => { const [offsetX, offsetY] = studio.map.onCanvas(place);
return studio.map.nearest({ offsetX, offsetY }); }"""


def test_a_landmark_is_moved_a_point_pinned_and_a_mask_painted_in_the_page(captures):
    shown, _ = gather([captures / "smile.exr"])
    server = Studio(shown).open("127.0.0.1")
    with browser() as chromium:
        page = page_at(chromium, server.address)
        page.evaluate("studio.map.ready")
        page.click("#map-open")
        box = page.locator("#map").bounding_box()

        def window(place):
            x, y = page.evaluate("(place) => studio.map.onCanvas(place)", place)
            return box["x"] + x, box["y"] + y

        def drag(start, end):
            page.mouse.move(*window(start))
            page.mouse.down()
            page.mouse.move(*window(end), steps=3)
            page.mouse.up()
            page.evaluate("studio.map.saver.queue")
            return read_corrections(captures / FILE)["smile"]

        at = face_landmarks().pixels(LAYOUT)
        key = int(page.evaluate(NEAREST, at[61].tolist()))
        said = drag(at[key].tolist(), (at[key] + [9, 5]).tolist())
        np.testing.assert_allclose(said.landmarks[key], at[key] + [9, 5], atol=1)
        page.select_option("#map-tool", "pins")
        said = drag([170, 90], [170, 90])
        np.testing.assert_allclose(said.pins["p1"], [170, 90], atol=1)
        page.select_option("#map-tool", "paint")
        said = drag([100, 130], [130, 130])
        rows, columns = np.nonzero(said.painted)
        assert (rows.mean(), columns.mean()) == pytest.approx((130, 115), abs=2)
        page.click("#undo-map")
        page.wait_for_function("studio.map.said.mask === ''")
        page.wait_for_function("document.querySelector('#redo-map').disabled === false")
        page.click("#redo-map")
        page.wait_for_function("studio.map.said.mask !== ''")
        page.wait_for_function("studio.map.told.startsWith('saved')")
        page.evaluate("studio.map.saver.queue")
        page.reload()
        page.wait_for_function("window.studio")
        page.evaluate("studio.map.ready")
        assert page.evaluate("[Object.keys(studio.map.said.pins), studio.map.said.mask.length > 100]") == [["p1"], True]
    assert read_corrections(captures / FILE)["smile"].painted.sum() == said.painted.sum()
    server.shutdown()
    server.server_close()
