import numpy as np

from detail_patch import patch, training
from mien.detail.base_mesh import BaseConfig, base_mesh
from mien.detail.sampling import sampler
from mien.detail.thin_shell import thin_shell
from mien.detail.training import Aligned
from mien.mesh import closest_point


def scene():
    clips = training()
    base = base_mesh(clips.mesh, BaseConfig(vertices=0, smoothing_mm=0.0))
    shell = thin_shell(base.mesh, closest_point(base.mesh, clips.markers).attachment())
    return clips, sampler(clips, base, shell, 24, 5.0)


def test_a_step_along_the_normal_is_a_step_along_the_normal():
    clips, at = scene()
    normal = np.cross([1.0, 0, 0], [0, 1.0, 0])
    moved = Aligned(clips.markers, clips.mesh.vertices + 0.3 * normal, None)
    middle = np.abs(at.shell.mesh.vertices[at.shell.mesh.faces[at.texels.attachment.faces]].mean(axis=1)[:, 0]) < 3
    np.testing.assert_allclose(at.displacement(moved)[middle], np.tile([0, 0, 0.3], (middle.sum(), 1)), atol=0.05)


def test_base_motion_meets_the_markers_and_far_samples_are_no_skin():
    clips, at = scene()
    lift = 2.0 * np.eye(3)[2]
    together = at.displacement(Aligned(clips.markers + lift, clips.mesh.vertices + lift, None))
    still = at.displacement(Aligned(clips.markers, clips.mesh.vertices, None))
    np.testing.assert_allclose(together, still, atol=1e-3)
    torn = Aligned(clips.markers, clips.mesh.vertices + 9.0 * np.eye(3)[2], None)
    assert np.isnan(at.displacement(torn)).all()
    assert np.isfinite(at.displacement(Aligned(clips.markers, patch().vertices, None))).all()
