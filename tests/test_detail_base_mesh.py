import numpy as np
import pytest
from scipy.spatial import KDTree

from detail_patch import patch, wrinkled
from mien.detail.base_mesh import RIM_MM, BaseConfig, base_mesh, decimated, outer_skin, rims_and_eyes, smooth_surface
from mien.errors import BadInput
from mien.faces import load_face
from mien.mesh import Mesh, closest_point


def test_the_bundled_head_s_outer_skin_has_no_sock_no_eyes_and_one_piece():
    face = load_face()
    mesh = face.rig.neutral
    kept = outer_skin(mesh)
    used = np.unique(mesh.faces[kept])
    assert not np.isin(used, np.concatenate([face.parts[p] for p in ("left_eye", "right_eye", "tongue")])).any()
    front = (face.regions["face"] > 0.9) & (mesh.vertices[:, 2] > 40)
    assert np.isin(np.flatnonzero(front), used).mean() > 0.75


def test_rims_and_eyes_of_the_bundled_head_go_with_their_own_lid_and_lip():
    """A smaller base's rims: eyeballs have no place on it, lips one near them; a patch has no rims."""
    face = load_face()
    mesh = face.rig.neutral
    base = base_mesh(mesh, BaseConfig(vertices=2000))
    parts = rims_and_eyes(mesh, base)
    eyes = parts.uv[:, 0] < 0
    assert eyes.sum() == sum(len(face.parts[side]) for side in ("left_eye", "right_eye"))
    assert ((parts.uv[~eyes] > 0) & (parts.uv[~eyes] < 1)).all()
    place = closest_uv(base.mesh, parts.uv[~eyes])
    off = np.linalg.norm(place - parts.vertices[~eyes], axis=1)
    assert np.median(off) < 5
    assert off.max() < RIM_MM + 5
    assert rims_and_eyes(patch(), base_mesh(patch(), BaseConfig(vertices=0))) is None


def closest_uv(mesh, uv):
    """The vertices whose texture coordinates are nearest."""
    return mesh.vertices[KDTree(mesh.uv).query(uv)[1]]


def test_smoothing_takes_furrows_and_leaves_the_shape():
    mesh = patch()
    rough = mesh.with_vertices(wrinkled(mesh, 0.2, 0.0, 0.5) - wrinkled(mesh, 0.2, 0.0, 0.0) + mesh.vertices)
    smooth = smooth_surface(rough, 15.0)
    inner = (np.abs(mesh.vertices[:, :2]) < 12).all(axis=1)
    left = np.ptp((smooth - mesh.vertices)[inner, 2]) / np.ptp((rough.vertices - mesh.vertices)[inner, 2])
    assert left < 0.35
    np.testing.assert_array_equal(smooth_surface(rough, 0.0), rough.vertices)


def test_the_base_lies_on_the_training_skin():
    mesh = patch()
    base = base_mesh(mesh, BaseConfig(vertices=400, smoothing_mm=0.0))
    assert 350 < len(base.mesh.vertices) < 450
    assert closest_point(mesh, base.mesh.vertices).distances.max() < 0.5
    at = closest_point(base.mesh, mesh.vertices[::50]).attachment()
    found = base.on_training(at).points(mesh)
    assert np.linalg.norm(found - at.points(base.mesh), axis=1).max() < 0.5


def test_what_cannot_be_a_face_is_refused():
    mesh = patch(9)
    inside_out = Mesh(mesh.vertices, mesh.faces[:, ::-1])
    with pytest.raises(BadInput, match="outer skin"):
        base_mesh(inside_out)
    doubled = Mesh(mesh.vertices, np.concatenate([mesh.faces, mesh.faces[:1]]))
    with pytest.raises(BadInput, match="more than two triangles"):
        decimated(doubled, 20)
