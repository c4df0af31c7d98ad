"""Skin far from markers is expected where their motion carries it."""

from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from mien.faces import load_face
from mien.mesh import Attachment
from mien.scans.correspond.large_scale import LargeScaleConfig, LargeScaleTarget, register
from mien.scans.correspond.unmarked_skin import UnmarkedConfig, unmarked_anchors
from small_scans import bundled_template, front_of


def open_jaw() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The template's skin with the jaw open, how far that moves it, and which skin hangs below the chin."""
    template, rig = bundled_template(), load_face().rig
    moved = 0.7 * rig.deltas[rig.index("jawOpen")][template.members]
    height = template.skin.vertices[:, 1]
    below = template.shown & (template.regions["face"] < 0.5) & (height < -70) & (np.linalg.norm(moved, axis=1) > 3)
    return template.skin.vertices + moved, moved, below


def markers_on_the_face(count: int = 60) -> Attachment:
    """Spread evenly over the face: each is the farthest from those before it."""
    template = bundled_template()
    where = template.skin.vertices[(template.regions["face"] > 0.5) & template.shown]
    chosen, away = [0], np.full(len(where), np.inf)
    for _ in range(count - 1):
        away = np.minimum(away, np.linalg.norm(where - where[chosen[-1]], axis=1))
        chosen.append(int(away.argmax()))
    return template.attachment_of(template.skin.vertices, where[chosen])


def test_skin_below_the_chin_goes_with_the_jaw():
    template, (goal, moved, below) = bundled_template(), open_jaw()
    places = markers_on_the_face()
    points = places.points(template.skin.with_vertices(goal))
    target = LargeScaleTarget(front_of(template.skin.with_vertices(goal)), points, np.ones(len(points), bool), None)
    found = register(template, places, target)
    config = LargeScaleConfig(unmarked=UnmarkedConfig(weight=0.0))
    without = register(template, places, target, config)
    off, off_without = (np.linalg.norm(x - goal, axis=1)[below].mean() for x in (found, without))
    assert below.sum() > 20
    assert off < 0.3 * off_without
    assert off < 0.1 * np.linalg.norm(moved, axis=1)[below].mean()


def test_only_skin_far_from_markers_and_from_lips_and_lids_is_held():
    template, (goal, *_) = bundled_template(), open_jaw()
    places, config = markers_on_the_face(), UnmarkedConfig(weight=0.3)
    points, covered = places.points(template.skin.with_vertices(goal)), np.ones(len(places.faces), bool)
    anchors = unmarked_anchors(template, places, points, covered, config, scale=0.01)
    held = anchors.attachment.points(template.skin)
    assert KDTree(places.points(template.skin)).query(held)[0].min() > config.far_mm
    edges = template.skin.vertices[template.sides != 0]
    assert KDTree(edges).query(held)[0].min() > config.off_edges_mm
    np.testing.assert_allclose(anchors.weights, 0.003)


def test_a_marker_that_does_not_count_says_nothing():
    template, (goal, *_) = bundled_template(), open_jaw()
    places, config = markers_on_the_face(), UnmarkedConfig()
    points, covered = places.points(template.skin.with_vertices(goal)), np.ones(len(places.faces), bool)
    covered[::7] = False
    wrong = np.where(covered[:, None], points, points + 50.0)
    right, told = (unmarked_anchors(template, places, x, covered, config, 1.0) for x in (points, wrong))
    np.testing.assert_array_equal(right.points, told.points)


def test_it_is_left_out_where_nothing_is_known():
    template, (goal, *_) = bundled_template(), open_jaw()
    places = markers_on_the_face()
    points, covered = places.points(template.skin.with_vertices(goal)), np.ones(len(places.faces), bool)
    stranger, told = replace(template, person=None), (places, points, covered)
    assert unmarked_anchors(stranger, *told, UnmarkedConfig(), 1.0) is None
    assert unmarked_anchors(template, *told, UnmarkedConfig(weight=0.0), 1.0) is None
    assert unmarked_anchors(template, *told, UnmarkedConfig(far_mm=1e3), 1.0) is None
    assert unmarked_anchors(template, places, points, ~covered, UnmarkedConfig(), 1.0) is None
