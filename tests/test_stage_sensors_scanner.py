"""Scans: exactly on the skin but for the noise asked for, in a topology and a frame of their own, truth kept."""

from dataclasses import replace

import numpy as np
import pytest

from mien.errors import BadInput
from mien.mesh import boundary_vertices, closest_point, face_normals, vertex_normals
from mien.stage import ScanConfig, SkinConfig, make_performer, make_skin, scan
from mien.stage.sensors.scanner import perform_nearly

EXACT = ScanConfig(vertices=4000, noise=0.0, ripple=0.0, performance_sigma=0.0, shiny=0.0)


@pytest.fixture(scope="module")
def skin():
    return make_skin(make_performer(6), SkinConfig(levels=1))


@pytest.fixture(scope="module")
def smile(skin):
    weights = np.zeros(52)
    weights[[skin.names.index(n) for n in ("mouthSmileLeft", "mouthSmileRight", "browInnerUp")]] = 0.7
    return weights


def test_without_noise_the_scan_is_the_skin(skin, smile):
    staged = scan(skin, smile, EXACT)
    true = staged.truth.points(staged.truth.material)
    np.testing.assert_allclose(staged.scan.mesh.vertices, true, atol=1e-3)
    back = staged.truth.T_scan_face.inverse().apply(staged.scan.mesh.vertices)
    assert closest_point(skin.mesh(smile), back).distances.max() < 1e-3


def test_noise_is_as_asked_and_along_the_rays(skin, smile):
    staged = scan(skin, smile, ScanConfig(vertices=4000, noise=0.08, ripple=0.0, performance_sigma=0.0, shiny=1.0))
    off = np.linalg.norm(staged.scan.mesh.vertices - staged.truth.points(staged.truth.material), axis=1)
    np.testing.assert_allclose(np.sqrt((off**2).mean()), 0.08, rtol=0.06)


def test_bundled_vertices_are_where_they_truly_are(skin, smile):
    truth = scan(skin, smile, EXACT).truth
    there = ~np.isnan(truth.bundled).any(axis=1)
    expected = truth.T_scan_face.apply(skin.vertices(smile[None])[0])[skin.bundled[there]]
    np.testing.assert_allclose(truth.bundled[there], expected, atol=1e-9)


def test_the_scan_is_a_clean_open_surface_of_its_own(skin, smile):
    mesh = scan(skin, smile, EXACT).scan.mesh
    assert 0.6 * 4000 < len(mesh.vertices) < 1.4 * 4000
    assert len(np.unique(mesh.faces)) == len(mesh.vertices)
    edges = np.sort(mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert np.unique(edges, axis=0, return_counts=True)[1].max() == 2
    assert len(boundary_vertices(mesh.faces)) > 100
    assert np.abs(np.diff(mesh.faces[:, 0])).mean() > len(mesh.vertices) / 5
    assert mesh.colors is not None


def test_triangles_look_outwards(skin, smile):
    mesh = scan(skin, smile, EXACT).scan.mesh
    middle = mesh.vertices.mean(axis=0) - [0, 0, 40]
    centres = mesh.vertices[mesh.faces].mean(axis=1)
    assert ((face_normals(mesh.vertices, mesh.faces) * (centres - middle)).sum(axis=1) > 0).mean() > 0.95


def test_holes_are_where_rays_graze(skin, smile):
    staged = scan(skin, smile, EXACT)
    surface = staged.truth.actor.neutral.with_vertices(staged.truth.vertices)
    normals = vertex_normals(surface.vertices, surface.faces)
    upright = normals @ staged.truth.T_scan_face.rotation
    distance = closest_point(staged.scan.mesh, surface.vertices).distances
    below, ahead = skin.skin & (upright[:, 1] < -0.95), skin.skin & (upright[:, 2] > 0.9)
    assert np.median(distance[below]) > 5 * np.median(distance[ahead])


def test_the_performed_expression_is_near_the_one_asked_for(skin, smile):
    for distance in (0.3, 0.8):
        performed = perform_nearly(skin, smile, distance, np.random.default_rng(0))
        performer = skin.performer
        front = performer.skin & (performer.neutral.vertices[:, 2] > 45)
        off = performer.vertices(np.stack([smile, performed]))[:, front]
        np.testing.assert_allclose(np.linalg.norm(off[1] - off[0], axis=1).mean(), distance, rtol=0.1)
    np.testing.assert_array_equal(perform_nearly(skin, smile, 0.0, np.random.default_rng(0)), smile)


def test_frames_and_seeds(skin, smile):
    a, b, c = (scan(skin, smile, EXACT, seed=s) for s in (1, 1, 2))
    np.testing.assert_array_equal(a.scan.mesh.vertices, b.scan.mesh.vertices)
    assert np.abs(a.truth.T_scan_face.translation - c.truth.T_scan_face.translation).max() > 1
    aligned = scan(skin, smile, ScanConfig(vertices=2000, turn=0.0, shift=0.0))
    np.testing.assert_array_equal(aligned.truth.T_scan_face.rotation, np.eye(3))
    np.testing.assert_array_equal(aligned.truth.T_scan_face.translation, 0.0)


def test_a_bare_performer_can_be_scanned_too(smile):
    performer = make_performer(6)
    staged = scan(performer, smile, EXACT)
    np.testing.assert_allclose(staged.truth.bundled, staged.truth.vertices)


def test_what_cannot_be_scanned_is_refused(skin, smile):
    with pytest.raises(BadInput, match="weights"):
        scan(skin, smile[:-1])
    with pytest.raises(BadInput, match="vertices"):
        scan(skin, smile, ScanConfig(vertices=3))


def test_a_beard_lifts_the_scan_and_noise_differs_between_scans(skin, smile):
    bearded = scan(skin, smile, replace(EXACT, beard=5.0))
    off = np.linalg.norm(bearded.scan.mesh.vertices - bearded.truth.points(bearded.truth.material), axis=1)
    assert off.max() > 2.0
    assert np.median(off) < 1e-3
    noisy = replace(EXACT, noise=0.1, noise_varies=0.5)
    sizes = []
    for seed in (1, 2, 3):
        staged = scan(skin, smile, noisy, seed=seed)
        true = staged.truth.points(staged.truth.material)
        sizes.append(np.linalg.norm(staged.scan.mesh.vertices - true, axis=1).std())
    assert max(sizes) > 1.2 * min(sizes)
