"""The 52 shapes from a few captures."""

import numpy as np
import pytest

from mien.blendshapes.build.arkit import (
    CompleteConfig,
    complete_arkit,
    completed_rig,
    find_mixes,
    pulled,
    transferred,
)
from mien.faces import load_face
from mien.mesh import loop_subdivide, mass
from mien.rig import Rig
from mien.rig.transfer import nearest_faces

RIG = load_face().rig
AREAS = mass(RIG.neutral.vertices, RIG.neutral.faces) * load_face().regions["face"] + 1e-6


@pytest.fixture(scope="module")
def own() -> np.ndarray:
    """Another person's way of making the shapes: stronger, and tilted."""
    return RIG.deltas * 1.3 + 0.1 * np.roll(RIG.deltas, 1, axis=2)


def test_on_the_bundled_face_itself_transfer_changes_nothing():
    off = transferred(load_face(), RIG.neutral) - load_face().fitted_deltas(RIG.neutral.vertices)
    assert np.abs(off).max() < 0.02


def test_a_capture_with_an_arkit_name_is_that_shape(own):
    jaw, smile = RIG.index("jawOpen"), RIG.index("mouthSmileLeft")
    found = complete_arkit(RIG.deltas, ("jawOpen",), own[[jaw]], AREAS)
    moved = np.abs(own[jaw]).max(1) > 1
    assert np.abs(found.deltas[jaw] - own[jaw])[moved].max() < 0.05 * np.abs(own[jaw]).max()
    np.testing.assert_array_equal(found.deltas[smile], RIG.deltas[smile])
    assert found.mixes[0, jaw] == 1


def test_a_capture_of_several_shapes_is_taken_apart_and_given_back(own):
    both = [RIG.index("mouthSmileLeft"), RIG.index("mouthSmileRight")]
    example = 0.9 * own[both].sum(0)
    found = complete_arkit(RIG.deltas, ("smile",), example[None], AREAS)
    assert found.mixes[0, both].min() > 0.5
    again = np.tensordot(found.mixes[0], found.deltas, axes=1)
    before = np.tensordot(find_mixes(RIG.deltas, ("smile",), example[None], AREAS, 0.3)[0], RIG.deltas, axes=1)
    assert np.linalg.norm(again - example) < 0.2 * np.linalg.norm(before - example)


def test_no_captures_or_no_rounds_leave_the_transferred_shapes(own):
    empty = np.zeros((0, *own.shape[1:]))
    np.testing.assert_array_equal(complete_arkit(RIG.deltas, (), empty, AREAS).deltas, RIG.deltas)
    off = complete_arkit(RIG.deltas, ("jawOpen",), own[[0]], AREAS, CompleteConfig(rounds=0))
    np.testing.assert_array_equal(off.deltas, RIG.deltas)


def test_what_a_shape_does_not_move_is_changed_last():
    prior, mixes = np.zeros((52, 2, 3)), np.zeros((1, 52))
    prior[0, 0], prior[1, 1] = 5.0, 5.0
    mixes[0, :2] = 1.0
    example = np.full((1, 2, 3), 6.0)
    made = pulled(prior, mixes, example, CompleteConfig(exact=0.0))
    np.testing.assert_allclose(made[0, 0], 6.0, atol=0.01)
    np.testing.assert_allclose(made[0, 1], 0.0, atol=0.01)


def test_a_rig_of_scans_in_another_topology_gets_the_52(own):
    """The smile that was scanned stays as scanned, and pulls the shapes that it is made of."""
    sides = [RIG.index("mouthSmileLeft"), RIG.index("mouthSmileRight")]
    dense, S = loop_subdivide(RIG.neutral, 1)
    scanned = Rig(dense, (S @ (0.9 * own[sides].sum(0)))[None], ("frame_000012",))
    found = completed_rig(scanned, load_face(), nearest_faces(RIG.neutral, dense))
    assert found.names == (*RIG.names, "frame_000012")
    np.testing.assert_array_equal(found.deltas[-1], scanned.deltas[0])
    jaw = RIG.index("jawOpen")
    off = np.linalg.norm(found.deltas[jaw] - S @ RIG.deltas[jaw], axis=1)
    assert np.median(off[np.linalg.norm(S @ RIG.deltas[jaw], axis=1) > 2]) < 0.5
    areas = mass(dense.vertices, dense.faces) + 1e-6

    def left(shapes) -> float:
        mix = find_mixes(shapes, scanned.names, scanned.deltas, areas, 0.3)[0]
        return float(np.abs(np.tensordot(mix, shapes, axes=1) - scanned.deltas[0]).mean())

    assert left(found.deltas[:-1]) < 0.5 * left(np.stack([S @ delta for delta in RIG.deltas]))
