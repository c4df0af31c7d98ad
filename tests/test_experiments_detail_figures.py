import numpy as np

from detail_patch import training
from mien.detail.base_mesh import BaseConfig
from mien.detail.fit import DetailConfig, fit_detail
from mien.experiments.detail_figures import close_up, frozen, last_frame, synthesized, vectors_of

SMALL = DetailConfig(base=BaseConfig(vertices=0), medium_size=24, fine_size=48)


def test_frozen_maps_do_not_hear_of_the_deformation_and_live_ones_do():
    clips = training()
    model = fit_detail(clips, SMALL)
    aligned = last_frame(clips, clips.clips[0])
    vectors = vectors_of(model, aligned)
    still = frozen(model).medium.driven.values
    np.testing.assert_allclose(still(vectors), still(0 * vectors), atol=1e-6)
    truth = aligned.vertices
    made = synthesized(model, aligned)
    assert len(made.vertices) > len(truth)
    assert np.abs(made.vertices - synthesized(frozen(model), aligned).vertices).max() > 0.1


def test_a_close_up_has_its_spot_in_the_middle():
    mesh = training().mesh
    at = mesh.vertices[mesh.vertices[:, 2].argmax()]
    view = close_up(mesh.vertices, at)
    x, y, z = view.T_camera_face.apply(at[None])[0]
    assert abs(x / z) < 0.2
    assert abs(y / z) < 0.2
