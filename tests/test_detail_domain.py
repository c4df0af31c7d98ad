from dataclasses import replace

import numpy as np
import pytest

from detail_patch import marker_places, patch
from mien.detail.domain import (
    DomainConfig,
    agreeing_planes,
    deformation_vectors,
    fit_domain,
    marker_strains,
    neighbours,
    smooth_bases,
)
from mien.detail.marker_mesh import marker_mesh
from mien.detail.texture_space import texture_gradients
from mien.errors import BadInput


@pytest.fixture(scope="module")
def scene():
    mesh = patch()
    at = marker_places(mesh)
    coarse = marker_mesh(mesh, at)
    reference = at.points(mesh)
    return reference, coarse, marker_strains(mesh, at, reference, coarse, texture_gradients(mesh))


def test_at_the_neutral_nothing_is_deformed(scene):
    reference, _, strains = scene
    np.testing.assert_allclose(deformation_vectors(strains, reference[None]), 0, atol=1e-9)


def test_strain_by_hand(scene):
    """Eq. 2: y stretched by a tenth grows the deviation along v by a tenth, times sqrt |N2|; along u nothing."""
    reference, _, strains = scene
    S = deformation_vectors(strains, (reference * [1, 1.1, 1])[None])[0]
    ring = strains.ring.toarray()[12] > 0
    expected = 0.1 * reference[ring, 1].std() * np.sqrt(ring.sum())
    assert S[12, 4] == pytest.approx(expected, rel=1e-6)
    assert abs(S[12, 3]) < 0.02 * expected
    np.testing.assert_allclose(S[:, 1], 0.1 * reference[:, 1], atol=1e-9)


def test_strain_does_not_feel_a_translation(scene):
    reference, _, strains = scene
    S = deformation_vectors(strains, (reference + np.array([3.0, -2.0, 1.0]))[None])[0]
    np.testing.assert_allclose(S[:, 3:], 0, atol=1e-6)
    np.testing.assert_allclose(S[:, :3], np.tile([3, -2, 1], (25, 1)))


def test_edge_strain_and_strain_alone(scene):
    reference, _, strains = scene
    edges = replace(strains, config=DomainConfig(edge_strain=True))
    stretched = (reference * [1, 1.1, 1])[None]
    assert deformation_vectors(edges, stretched)[0, 12, 4] > 0
    alone = replace(strains, config=DomainConfig(offsets=False))
    assert (deformation_vectors(alone, stretched)[..., :3] == 0).all()


def test_bases_are_orthonormal_and_hold_the_energy_of_two_motions(scene):
    reference, coarse, strains = scene
    amounts = np.linspace(-1, 1, 9)
    frames = [reference * [1, 1 + 0.1 * a, 1] for a in amounts] + [reference + a * np.eye(3)[2] for a in amounts]
    vectors = deformation_vectors(strains, np.stack(frames))
    domain = fit_domain(strains, coarse, vectors)
    eye = np.einsum("ksa,ksb->kab", domain.bases, domain.bases)
    np.testing.assert_allclose(eye, np.tile(np.eye(2), (25, 1, 1)), atol=1e-9)
    assert domain.energies[1] > 0.999
    assert np.all(np.diff(domain.energies) >= -1e-12)
    assert domain.energies[4] == pytest.approx(1)


def test_flipped_and_swapped_neighbours_are_brought_into_agreement(scene):
    _, coarse, _ = scene
    rng = np.random.default_rng(5)
    one = np.linalg.qr(rng.normal(size=(5, 2)))[0]
    bases = np.stack([one[:, rng.permutation(2)] * rng.choice([-1, 1], 2) for _ in range(25)])
    agreed = agreeing_planes(coarse, bases, rng.random(25))
    np.testing.assert_allclose(agreed, np.tile(agreed[:1], (25, 1, 1)), atol=1e-9)


def test_an_outlier_is_smoothed_and_the_rest_stays(scene):
    _, coarse, _ = scene
    bases = np.tile(np.eye(5)[:, :2], (25, 1, 1))
    bases[12] = np.eye(5)[:, 2:4]
    smooth, replaced = smooth_bases(coarse, bases)
    assert replaced == 1
    np.testing.assert_allclose(smooth[12], np.eye(5)[:, :2], atol=1e-9)
    same, none = smooth_bases(coarse, bases, DomainConfig(threshold_deg=180))
    assert none == 0
    np.testing.assert_array_equal(same, bases)


def test_neighbours_share_an_edge(scene):
    _, coarse, _ = scene
    around = neighbours(coarse, 25)
    for i, ring in enumerate(around):
        assert all(i in around[j] for j in ring)


def test_missing_markers_other_counts_and_no_motion_are_refused(scene):
    reference, coarse, strains = scene
    hidden = reference[None].copy()
    hidden[0, 7] = np.nan
    with pytest.raises(BadInput, match="marker 7 is missing in frame 0"):
        deformation_vectors(strains, hidden)
    with pytest.raises(BadInput, match="24 markers"):
        deformation_vectors(strains, reference[None, :24])
    with pytest.raises(BadInput, match="no marker moves"):
        fit_domain(strains, coarse, np.zeros((3, 25, 5)))


def test_beyond_the_trained_range_detail_is_what_it_was_at_its_end(scene):
    """A stretch by a tenth was trained on: d under a fifth is that under a tenth; within the range nothing changes."""
    reference, coarse, strains = scene
    trained = np.stack([reference * [1, 1 + 0.1 * a, 1] for a in np.linspace(0, 1, 5)])
    domain = fit_domain(strains, coarse, deformation_vectors(strains, trained))
    np.testing.assert_allclose(domain.vectors(trained), deformation_vectors(strains, trained), atol=1e-9)
    beyond = np.stack([reference * [1, 1.2, 1], reference * [1, 0.9, 1]])
    within = np.einsum("tka,kad->tkd", domain.vectors(beyond), domain.bases)
    ends = np.einsum("tka,kad->tkd", domain.vectors(trained[[-1, 0]]), domain.bases)
    strong = np.abs(domain.trained).max(axis=1) > 0.5
    np.testing.assert_allclose(within[:, strong], ends[:, strong], atol=0.05)
