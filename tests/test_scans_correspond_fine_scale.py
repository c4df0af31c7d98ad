"""Fine-scale registration: laws, known slides, constraints."""

from dataclasses import replace

import numpy as np
import pytest

from mien.errors import BadInput
from mien.image_space.config import FineConfig
from mien.image_space.constraints import PairConstraint
from mien.mesh import Mesh, closest_point
from mien.scans.correspond.fine_scale import closest_scans, register_fine
from mien.transforms import Transform, rotation_from_vector

COUNT = 41
QUICK = FineConfig(sweeps=3, pixel_mm=1.0)


def sheet(slide=0.0, depth=1.0, wave=0.0):
    """A piece of cylinder with furrows across; its vertices `slide` mm too high, more in the middle than at the rim."""
    angle, y = np.meshgrid(np.linspace(-0.5, 0.5, COUNT), np.linspace(-40, 40, COUNT))
    bump = np.cos(np.pi * angle) ** 2 * np.cos(np.pi * y / 80) ** 2
    at = y + slide * bump
    height = depth * furrows(at, angle) + wave * np.cos(angle * 3)
    x, z = (80 + height) * np.sin(angle), (80 + height) * np.cos(angle)
    return np.stack([x, at, z], -1).reshape(-1, 3)


def furrows(y, angle):
    lines = 0.5 + 0.5 * np.cos(2 * np.pi * (y + 3 * np.sin(4 * angle)) / 12)
    return -(lines**4) * np.exp(-((y / 25) ** 4) - (angle / 0.35) ** 4)


def triangles():
    index = np.arange(COUNT * COUNT).reshape(COUNT, COUNT)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    return np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])


def regions():
    side = np.tile(np.linspace(0, 1, COUNT), (COUNT, 1)).ravel()
    return {"right": np.clip(3 - 5 * side, 0, 1), "left": np.clip(5 * side - 2, 0, 1)}


FACES = triangles()
INNER = (np.abs(sheet()[:, 1]) < 22) & (np.abs(sheet()[:, 0]) < 20)


def test_identical_scans_stay_as_they_are():
    found = register_fine(np.stack([sheet()] * 3), FACES, regions(), config=QUICK)
    np.testing.assert_allclose(found.vertices, np.stack([sheet()] * 3), atol=0.02)
    np.testing.assert_allclose(found.moved, 0, atol=0.01)
    np.testing.assert_allclose(found.errors, 0, atol=1e-3)
    assert not found.unreliable.any()


@pytest.fixture(scope="module")
def slid():
    """Four sheets with the same furrows, the last with its vertices in the wrong places."""
    shapes = np.stack([sheet(), sheet(), sheet(), sheet(2.5)])
    return shapes, register_fine(shapes, FACES, regions(), config=QUICK)


def off_by(vertices):
    """Mean distance of each scan's inner vertices from where they belong, mm."""
    return np.linalg.norm(vertices - sheet(), axis=2)[:, INNER].mean(axis=1)


def test_a_slide_is_undone(slid):
    shapes, found = slid
    assert off_by(shapes)[3] > 1.0
    assert off_by(found.vertices).max() < 0.4
    assert (found.errors[3] < 0.5 * found.before[3]).all()


def test_vertices_stay_on_their_surface(slid):
    shapes, found = slid
    for before, after in zip(shapes, found.vertices, strict=True):
        assert closest_point(Mesh(before, FACES), after).distances.max() < 1e-9
    np.testing.assert_allclose(found.moved[3], np.linalg.norm(found.vertices[3] - shapes[3], axis=1).mean(), rtol=1e-9)


def test_no_triangle_turns_over(slid):
    _, found = slid
    for vertices in found.vertices:
        angle = np.arctan2(vertices[:, 0], vertices[:, 2])
        flat = np.stack([angle * 80, vertices[:, 1]], 1)[FACES]
        b, c = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
        assert (b[:, 0] * c[:, 1] > b[:, 1] * c[:, 0]).all()


def test_only_some_scans_are_redone(slid):
    shapes, found = slid
    again = register_fine(shapes, FACES, regions(), config=QUICK, only=[3])
    np.testing.assert_array_equal(again.vertices[:3], shapes[:3])
    assert off_by(again.vertices)[3] < 0.4
    kept = register_fine(shapes, FACES, regions(), config=QUICK, only=[], start=found.vertices)
    np.testing.assert_array_equal(kept.vertices, found.vertices)
    np.testing.assert_allclose(kept.errors, found.errors, atol=2e-3)


def test_regions_that_do_not_agree_are_marked(slid):
    shapes, found = slid
    strict = FineConfig(sweeps=0, pixel_mm=1.0, unreliable=float(found.before[3].min()) / 2)
    marked = register_fine(shapes, FACES, regions(), config=strict)
    np.testing.assert_array_equal(marked.vertices, shapes)
    np.testing.assert_array_equal(marked.errors, marked.before)
    assert marked.unreliable[3].all()
    assert not found.unreliable.any()


def test_one_scan_has_nothing_to_go_by():
    found = register_fine(sheet()[None], FACES, regions(), config=QUICK)
    np.testing.assert_array_equal(found.vertices[0], sheet())
    assert found.neighbours.shape == (1, 2, 0)
    assert not found.unreliable.any()


def test_colours_align_where_nothing_else_does():
    scan, slipped = sheet(depth=0.0), sheet(1.5, depth=0.0)
    x, y, _ = scan.T
    spots = 0.5 + 0.2 * np.sin(x / 1.7) * np.sin(y / 1.9) + 0.1 * np.sin(x / 1.1 + y / 1.4)
    surface = Mesh(scan, FACES, colors=np.repeat(spots[:, None], 3, axis=1))
    shapes = np.stack([scan, scan, slipped])
    given = {"scans": [surface] * 3, "only": [2]}
    assert off_by(shapes)[2] > 0.8
    assert off_by(register_fine(shapes, FACES, regions(), config=QUICK, **given).vertices)[2] < 0.25
    blind = replace(QUICK, colour=None)
    assert off_by(register_fine(shapes, FACES, regions(), config=blind, **given).vertices)[2] > 0.8


def test_closest_scans_know_no_rigid_motion():
    rng = np.random.default_rng(0)
    base, wild = rng.normal(size=(2, 50, 3))
    scans = np.stack([base, base + 0.3 * wild, base + 0.1 * wild, base + wild])
    turned = Transform(rotation_from_vector(np.array([0.3, -0.5, 0.2])), np.array([9.0, -4.0, 2.0])).apply(scans[2])
    near = closest_scans(np.stack([*scans[:2], turned, scans[3]]), {"all": np.ones(50)}, 2)
    np.testing.assert_array_equal(near[:, 0], [[2, 1], [2, 0], [0, 1], [1, 2]])
    assert closest_scans(scans[:2], {"all": np.ones(50)}, 3).shape == (2, 1, 1)


def test_points_that_are_the_same_meet():
    """Two sheets without a feature: what is pointed out alone moves them."""
    shapes = np.stack([sheet(depth=0.0), sheet(depth=0.0)])
    below, above = np.array([[0.0, -6.0, 80.0]]), np.array([[0.0, 2.0, 80.0]])
    held = PairConstraint((0, 1), np.stack([below, above]))
    found = register_fine(shapes, FACES, regions(), config=QUICK, constraints=[held])
    meshes = [Mesh(v, FACES) for v in found.vertices]
    there = closest_point(meshes[0], below).attachment().points(meshes[1])
    np.testing.assert_allclose(there, above, atol=0.5)
    met = found.by_hand
    np.testing.assert_allclose(met.before, 8.0, atol=0.1)  # one sheet is the other
    np.testing.assert_allclose(met.after, np.linalg.norm(there - above, axis=1))
    assert register_fine(shapes, FACES, regions(), config=QUICK, only=[]).by_hand is None


def test_lines_that_are_the_same_meet():
    shapes = np.stack([sheet(depth=0.0), sheet(depth=0.0)])
    along = np.linspace(-10, 10, 9)
    one, other = (np.stack([along, np.full(9, y), np.sqrt(6400 - along**2)], 1) for y in (-2.0, 2.0))
    held = PairConstraint((0, 1), np.zeros((2, 0, 3)), ((one, other),))
    found = register_fine(shapes, FACES, regions(), config=QUICK, constraints=[held])
    there = closest_point(Mesh(found.vertices[0], FACES), one).attachment().points(Mesh(found.vertices[1], FACES))
    np.testing.assert_allclose(there[1:-1, 1], 2.0, atol=0.5)


def test_what_does_not_fit_is_named():
    shapes = np.stack([sheet(), sheet()])
    far = PairConstraint((0, 1), np.full((2, 1, 3), 500.0))
    wrong = PairConstraint((0, 2), np.zeros((2, 0, 3)))
    cases = [
        ({"regions": {}}, "no regions"),
        ({"regions": {"all": np.ones(5)}}, "region all must have one value"),
        ({"regions": {"none": np.zeros(len(sheet()))}}, "no triangle lies in any region"),
        ({"scans": [Mesh(sheet(), FACES)]}, "1 surfaces for 2 scans"),
        ({"only": [2]}, "from 0 to 1"),
        ({"constraints": [wrong]}, "constraints must name scans"),
        ({"constraints": [far]}, "mm off the scan"),
    ]
    for given, message in cases:
        with pytest.raises(BadInput, match=message):
            register_fine(shapes, FACES, **{"regions": regions(), "config": QUICK, **given})
    with pytest.raises(BadInput, match="neighbours, alpha out of range"):
        FineConfig(neighbours=0, alpha=-1.0)


def test_vertices_follow_as_far_as_their_weight_says(slid):
    shapes, found = slid
    half = register_fine(shapes, FACES, regions(), weight=np.full(len(sheet()), 0.5), config=QUICK)
    np.testing.assert_allclose(half.vertices, (shapes + found.vertices) / 2, atol=1e-9)


def test_it_is_told_where_the_flow_did_not_converge(slid):
    shapes, found = slid
    assert found.converged.shape == (4, 2)
    hasty = replace(QUICK, sweeps=1, flow=replace(QUICK.flow, warps=1, tolerance=0.0))
    assert not register_fine(shapes, FACES, regions(), config=hasty).converged[3].any()
