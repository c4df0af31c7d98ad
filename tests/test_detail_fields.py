import numpy as np
import pytest

from detail_patch import training
from mien.detail.base_mesh import BaseConfig, base_mesh
from mien.detail.domain import deformation_vectors
from mien.detail.fields import parameter_field
from mien.detail.fit import training_domain
from mien.mesh import closest_point


def test_at_a_marker_the_parameters_are_its_own_dot_products():
    """Eq. 3 by hand: d1 = S . Q, d2 = S . R at the marker; 0 everywhere at the neutral."""
    clips = training()
    base = base_mesh(clips.mesh, BaseConfig(vertices=0, smoothing_mm=0.0)).mesh
    at = closest_point(base, clips.markers).attachment()
    domain = training_domain(clips, base, at)
    field = parameter_field(domain, base, at, at)
    S = deformation_vectors(domain.strains, (clips.markers * [0.9, 1.05, 1])[None])[0]
    expected = np.einsum("ks,ksd->kd", S, domain.bases)
    np.testing.assert_allclose(field.parameters(S), expected, rtol=1e-3, atol=1e-3)
    whole = field.parameters(S, whole=True)
    np.testing.assert_allclose(whole, np.concatenate([expected, S], 1), rtol=1e-3, atol=1e-3)
    assert np.abs(field.parameters(np.zeros((25, 5)))).max() == pytest.approx(0)
