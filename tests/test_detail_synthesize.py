from dataclasses import replace

import numpy as np
import pytest

from detail_patch import bent, marker_places, patch, training, wrinkled
from mien.detail.base_mesh import BaseConfig
from mien.detail.fit import DetailConfig, fit_detail
from mien.detail.synthesize import SynthesisConfig, SynthesizedFrame, Synthesizer, at_vertices, coloured
from mien.mesh import closest_point


@pytest.fixture(scope="module")
def model():
    return fit_detail(training(), DetailConfig(base=BaseConfig(vertices=0), medium_size=20, fine_size=96))


def synthesized(model, squeeze, config):
    """A frame, and the true skin moved likewise."""
    mesh = patch()
    at = marker_places(mesh)
    markers = at.points(mesh.with_vertices(bent(mesh.vertices, squeeze, 0.0)))[None]
    T = model.head.pose(markers).inverse()[0]
    synthesizer = Synthesizer(model, config)
    frame = synthesizer.frame(model.head.aligned(markers)[0])
    return synthesizer, frame, mesh.with_vertices(T.apply(wrinkled(mesh, squeeze, 0.0, 0.4)))


def distance(synthesizer, frame, truth):
    inner = (np.abs(synthesizer.mesh.vertices[:, :2]) < 22).all(axis=1)
    return closest_point(truth, frame.vertices[inner].astype(float)).distances.mean()


def test_each_map_brings_an_unseen_squeeze_nearer_to_the_truth(model):
    """Half-way between training frames: shell, + medium, + fine."""
    errors = []
    for config in (
        SynthesisConfig(medium=False),
        SynthesisConfig(),
        SynthesisConfig(fine_vertices=True),
    ):
        errors.append(distance(*synthesized(model, 0.17, config)))
    assert errors[1] < 0.5 * errors[0]
    assert errors[2] < 0.9 * errors[1]


def test_density_changes_the_mesh_and_hardly_the_shape(model):
    for levels, vertices in ((0, 33**2), (1, 65**2)):
        synthesizer, frame, truth = synthesized(model, 0.17, SynthesisConfig(levels=levels, fine_vertices=True))
        assert len(frame.vertices) == vertices
        assert distance(synthesizer, frame, truth) < 0.1


def test_frames_in_threads_are_the_frames_one_by_one(model):
    synthesizer = Synthesizer(model)
    markers = np.stack([model.reference * [1 - 0.02 * i, 1, 1] for i in range(9)])
    together = list(synthesizer.frames(markers, workers=2))
    for frame, one in zip(markers, together, strict=True):
        alone = synthesizer.frame(frame)
        np.testing.assert_array_equal(one.vertices, alone.vertices)
        np.testing.assert_array_equal(one.fine, alone.fine)


def test_coefficients_of_other_markers_are_not_mixed(model):
    """The right half of the map hangs on a triangle far away, with coefficients that mean nothing elsewhere."""
    detail, uv = model.medium, model.base.uv
    field = Synthesizer(model)._medium.field
    right = detail.texels.pixels % detail.texels.size >= detail.texels.size // 2
    far = int(field.triangle[uv[:, 0].argmin()])
    coefficients = np.ones_like(detail.polynomial.coefficients)
    coefficients[right] = 1000.0
    map_field = replace(detail.field, triangle=np.where(right, far, detail.field.triangle))
    changed = replace(detail, field=map_field, polynomial=replace(detail.polynomial, coefficients=coefficients))
    driven = at_vertices(changed, field, uv)
    read = driven.polynomial.coefficients[:, 0, 0]
    assert set(np.unique(read.round(3))) == {1.0, 1000.0}
    assert (driven.field.triangle[read > 500] == far).all()
    assert (driven.field.triangle[read < 500] == field.triangle[read < 500]).all()


def test_a_frame_s_albedo_is_on_the_mesh_as_it_is_shown():
    mesh = patch()
    albedo = np.full((len(mesh.vertices), 3), 0.5, np.float32)
    frame = SynthesizedFrame(mesh.vertices.astype(np.float32), None, albedo)
    np.testing.assert_allclose(coloured(mesh, frame).colors, 0.735, atol=2e-3)  # sRGB of half the light
    assert coloured(mesh, replace(frame, colors=None)) is mesh
