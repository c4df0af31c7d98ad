"""The warp from the neutral to an expression."""

from dataclasses import replace

import numpy as np
import pytest

from blendshape_faces import LAYOUT, face_landmarks, face_map, face_mesh
from mien.blendshapes.correspond import dense
from mien.blendshapes.correspond.dense import WarpConfig, features, warp
from mien.blendshapes.correspond.landmarks import MapLandmarks
from mien.blendshapes.correspond.matches import MatchConfig
from mien.faces import load_face
from mien.flow import FlowConstraints
from mien.image_space.layout import sampled
from mien.landmarks.detector import LOOPS

SMILE = {"mouthSmileLeft": 0.8, "mouthSmileRight": 0.8}


def rough(landmarks: MapLandmarks) -> MapLandmarks:
    """As a detector has them: off by a millimetre or two, many missing."""
    rng = np.random.default_rng(0)
    known = landmarks.known & (np.arange(478) % 6 == 0)
    return MapLandmarks(landmarks.points + rng.normal(scale=1.2, size=(478, 3)), known)


def error(found, true) -> float:
    """Median distance in mm of vertices on the face from their true pixels."""
    face = load_face().regions["narrow"] > 0.5
    places = LAYOUT.pixels(face_mesh().vertices)[face]
    goal = LAYOUT.pixels(true.vertices)[face]
    seen = sampled(found.shown.astype(float), places)[:, 0] > 0.5
    off = np.linalg.norm(sampled(found.pixels, places) - goal, axis=1)[seen]
    return float(np.median(off) * LAYOUT.pixel_mm)


@pytest.fixture(scope="module")
def pair():
    return face_map("smile", **SMILE), rough(face_landmarks(**SMILE)), face_map(), rough(face_landmarks())


def test_flow_goes_on_where_landmarks_end(pair):
    true = face_mesh(**SMILE)
    triangles = error(warp(*pair, config=WarpConfig(flow=None)), true)
    flowed = error(warp(*pair), true)
    assert flowed < 0.6 * triangles
    assert flowed < 0.7


def test_inside_of_the_mouth_is_not_shown():
    pair = face_map("jaw", jawOpen=0.7), face_landmarks(jawOpen=0.7), face_map(), face_landmarks()
    jaw = warp(*pair, config=WarpConfig(matches=MatchConfig(rounds=0)))
    lips = np.round(face_landmarks().pixels(LAYOUT)[13]).astype(int)
    assert not jaw.shown[lips[1] - 1 : lips[1] + 2, lips[0]].all()
    chin = np.round(face_landmarks().pixels(LAYOUT)[200]).astype(int)
    assert jaw.shown[chin[1], chin[0]]
    assert jaw.pixels[chin[1], chin[0], 1] - chin[1] > 10


STIFF = WarpConfig(passes=1, curvature=0.6, flow=replace(WarpConfig().flow, smoothness=3.0))
"""A flow that does not mend by itself what is set right before it."""


def test_lips_that_part_keep_to_their_landmarks(monkeypatch):
    there, here = face_landmarks(jawOpen=0.9), face_landmarks()
    pair = face_map("jaw", jawOpen=0.9), there, face_map(), here
    lips = list(LOOPS["lips_outer"])

    def off():
        found = sampled(warp(*pair, config=STIFF).pixels, here.pixels(LAYOUT)[lips])
        return np.linalg.norm(found - there.pixels(LAYOUT)[lips], axis=1).max() * LAYOUT.pixel_mm

    kept = off()
    monkeypatch.setattr(dense, "PARTED_MM", 1e9)
    assert kept < 0.6 * off()


def test_a_pinned_point_is_kept(pair):
    place = np.array([[170.0, 120.0]])
    pinned = FlowConstraints(place, place + np.array([6.0, 0.0]))
    found = warp(*pair, pinned=pinned)
    np.testing.assert_allclose(found.pixels[120, 170], [176, 120], atol=1.0)


def test_an_expected_motion_is_the_start(pair):
    blank = replace(pair[1], known=pair[1].known & (np.arange(478) < 10))
    shift = np.broadcast_to([7.0, 0.0], (*LAYOUT.shape, 2))
    found = warp(pair[0], blank, pair[2], pair[3], expected=shift, config=WarpConfig(flow=None, landmarks=False))
    np.testing.assert_allclose(found.pixels[100, 150], [157, 100])


def test_features_are_nan_off_the_mask_and_blind_to_light():
    mask = face_map().known
    bright = replace(face_map(), colors=np.clip(face_map().colors * 0.8 + 0.1, 0, 1).astype(np.float32))
    one, other = features(face_map(), mask, WarpConfig()), features(bright, mask, WarpConfig())
    assert np.isnan(one[~mask]).all()
    assert np.corrcoef(one[mask][:, 0], other[mask][:, 0])[0, 1] > 0.98


def test_matches_mend_landmarks_that_stay_behind():
    """Brows that go up while the detector leaves theirs where they were."""
    raised = {"browInnerUp": 1.0, "browOuterUpLeft": 1.0, "browOuterUpRight": 1.0}
    source, neutral, calm = face_map("brows", **raised), face_map(), face_landmarks()
    true = face_mesh(**raised)
    brow = np.linalg.norm(face_mesh().vertices - true.vertices, axis=1) > 4.0
    places, goal = LAYOUT.pixels(face_mesh().vertices)[brow], LAYOUT.pixels(true.vertices)[brow]

    def left(config: WarpConfig) -> float:
        found = warp(source, calm, neutral, calm, config=config)
        return float(np.median(np.linalg.norm(sampled(found.pixels, places) - goal, axis=1)))

    without = left(replace(STIFF, matches=MatchConfig(rounds=0)))
    assert left(STIFF) < 0.6 * without
