"""Virtual markers: on the skin that moves, far from each other, moving as the face does."""

import numpy as np
import pytest

from gltf_files import performance, rig
from mien.rig.virtual_markers import sample_markers, virtual_markers


def test_they_are_vertices_spread_over_what_moves():
    face = rig()
    attachment = sample_markers(face, 30)
    points = attachment.points(face.neutral)
    vertices = face.neutral.vertices
    near = np.linalg.norm(points[:, None] - vertices, axis=2)
    np.testing.assert_allclose(near.min(axis=1), 0, atol=1e-12)
    used = np.unique(face.neutral.faces)
    assert set(near.argmin(axis=1)) <= set(used.tolist())
    apart = np.linalg.norm(points[:, None] - points, axis=2) + 1e9 * np.eye(30)
    assert apart.min() > 15


def test_they_move_as_the_face_does():
    play = performance(5)
    attachment = sample_markers(play.rig, 7)
    markers = virtual_markers(play, attachment, [f"v{i}" for i in range(7)])
    for t, mesh in enumerate(play.meshes(world=True)):
        if play.tracked[t]:
            np.testing.assert_allclose(markers.positions[t], attachment.points(mesh), atol=1e-9)
        else:
            assert np.isnan(markers.positions[t]).all()
    assert markers.rate == play.rate


@pytest.mark.parametrize("count", [0, 100000])
def test_a_count_that_cannot_be_is_told(count):
    with pytest.raises(ValueError, match=r"expected 1\.\."):
        sample_markers(rig(), count)
