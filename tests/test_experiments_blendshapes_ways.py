"""Ways to correspondence side by side."""

from unittest.mock import Mock

import numpy as np
import pytest

from blendshape_faces import face_mesh
from blendshape_rig import JAW, built_rig, true_landmarks
from mien.blendshapes.align import AlignedCapture
from mien.experiments import blendshapes_ways
from mien.experiments.blendshapes_score import TrueSkin
from mien.experiments.blendshapes_ways import OURS, SIDE_DEG, TEMPLATE, errors_of, warp_of, ways
from mien.faces import load_face
from mien.transforms import Transform


@pytest.fixture(scope="module")
def aligned():
    map_ = built_rig().shapes[0].map
    return AlignedCapture(map_, true_landmarks(map_), Transform.identity(), 0.0)


def test_ours_is_nearer_than_the_closest_point(aligned, monkeypatch):
    neutral, face = built_rig().neutral, load_face()
    monkeypatch.setattr(blendshapes_ways, "template_fit", lambda *_: neutral.artist.mesh.vertices)
    found = ways(aligned, neutral, face)
    goal = face_mesh(**JAW).vertices
    low = (face.regions["narrow"] > 0.5) & (goal[:, 1] < -40) & neutral.artist.shown
    off = {name: np.nanmedian(np.linalg.norm(points - goal, axis=1)[low]) for name, points in found.items()}
    assert off[OURS] < 0.6 * off["closest point"]
    assert off[OURS] < 0.4 * off[TEMPLATE]


def test_the_warp_of_points_leads_to_them(aligned):
    neutral = built_rig().neutral
    moved = neutral.artist.mesh.vertices + np.array([3.0, 0.0, 0.0])
    slid = warp_of(moved, aligned, neutral)
    layout = neutral.map.layout
    nose = np.round(layout.pixels(np.array([[0.0, 0.0, 95.0]]))).astype(int)[0]
    assert 2 < slid.pixels[nose[1], nose[0], 0] - nose[0] < 4


def test_errors_by_hand(monkeypatch):
    neutral, face = built_rig().neutral, load_face()
    vertices = neutral.artist.mesh.vertices
    monkeypatch.setattr(blendshapes_ways, "drift", lambda truth, found, *_: np.full(len(found), 2.0))
    truth = Mock(spec=TrueSkin, scored=np.ones(len(vertices), bool))
    truth.points.return_value = vertices
    off = np.where(np.degrees(np.abs(np.arctan2(vertices[:, 0], vertices[:, 2]))) > SIDE_DEG, 3.0, 0.0)
    found = vertices + off[:, None] * [0.0, 1.0, 0.0]
    told = errors_of(found, truth, np.zeros(52), neutral, face)
    assert told["side mean"] == pytest.approx(3.0, abs=0.1)
    assert told["median"] < 0.5
    assert told["drift p95"] == 2.0
