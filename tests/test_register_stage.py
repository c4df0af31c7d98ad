"""Registration with markers on a scan of the synthetic stage, where the truth is known."""

import numpy as np
import pytest

from mien.faces.bundled import load_face
from mien.fitting.template_parts import TemplateParts
from mien.mesh import Attachment, ClosestPoint, Mesh, farthest_points, loop_refinement, vertex_normals
from mien.register import Anchors, Surface, Template
from mien.stage import make_performer
from mien.stage.people.skin import SkinConfig, make_skin
from mien.stage.sensors.scanner import ScanConfig
from mien.stage.sensors.scanner import scan as scan_actor


@pytest.fixture(scope="module")
def pair():
    """The subdivided skin of the average face, its trust, 100 markers; a scan with the mouth open; the truth."""
    face = load_face()
    body = TemplateParts(face)
    members = body.skin
    rest, trust = face.rig.neutral.vertices[members], body.trust[members]
    finer = loop_refinement(body.skin_triangles, len(rest))
    template = Mesh(finer.matrix @ rest, finer.faces)
    actor = make_skin(make_performer(3), SkinConfig(levels=2))
    weights = np.zeros(len(actor.names))
    weights[[actor.names.index(name) for name in ("jawOpen", "browInnerUp")]] = 0.6, 0.4
    made = scan_actor(actor, weights, ScanConfig(vertices=40_000), seed=6)
    T = made.truth.T_scan_face.inverse()
    truth = T.apply(made.truth.bundled)[members]
    face_part = face.regions["face"][members] > 0.5
    open_skin = np.flatnonzero(face_part & (trust > 0.3) & np.isfinite(truth).all(axis=1))
    marks = open_skin[farthest_points(rest[open_skin], 100)]
    scan = made.scan.mesh.with_vertices(T.apply(made.scan.mesh.vertices))
    return template, finer.between @ trust, finer.between @ face_part, marks, scan, truth


@pytest.fixture(scope="module")
def found(pair):
    template, trust, _, marks, scan, truth = pair
    anchors = Anchors(_at_vertices(template, marks), truth[marks], np.ones(len(marks)))
    return Template(template).register(Surface(scan), anchors, trust=trust)


def _at_vertices(mesh, vertices):
    """The attachment of vertices."""
    flat = mesh.faces.ravel()
    first = np.full(len(mesh.vertices), -1)
    first[flat[::-1]] = np.arange(len(flat))[::-1]
    corner = first[vertices]
    return Attachment(corner // 3, np.eye(3)[corner % 3])


def test_it_comes_to_lie_on_the_scan(pair, found):
    _, trust, region, *_ = pair
    shown = (region > 0.5) & (trust > 0.3) & found.accepted
    assert shown.sum() > 0.9 * ((region > 0.5) & (trust > 0.3)).sum()
    assert found.distances[shown].mean() < 0.1
    assert np.quantile(found.distances[shown], 0.95) < 0.3


def test_it_is_where_it_belongs(pair, found):
    """Between markers too, and far better than before."""
    template, _, region, marks, _, truth = pair
    n = len(truth)
    there = (region[:n] > 0.5) & np.isfinite(truth).all(axis=1)
    off = np.linalg.norm(found.vertices[:n] - truth, axis=1)[there]
    before = np.linalg.norm(template.vertices[:n] - truth, axis=1)[there]
    assert off.mean() < 1.0
    assert off.mean() < 0.15 * before.mean()
    np.testing.assert_allclose(found.vertices[marks], truth[marks], atol=0.02)


def test_lips_part_as_they_should(pair, found):
    """Lips that touch on the template are found where they are on a mouth that is open."""
    face = load_face()
    body, truth = TemplateParts(face), pair[5]
    place = np.full(len(face.rig.neutral.vertices), -1)
    place[body.skin] = np.arange(len(body.skin))
    lips = place[np.concatenate([edge for name, edge in face.contours.items() if "lip" in name or "mouth" in name])]
    assert len(lips) > 10
    assert (lips >= 0).all()
    off = np.linalg.norm(found.vertices[lips] - truth[lips], axis=1)
    assert np.nanmean(off) < 2.5
    assert np.nanmax(off) < 6


def test_triangles_keep_their_side(pair, found):
    """No folds on the open face: neighbouring normals agree."""
    template, trust, region, _, scan, _ = pair
    normals = vertex_normals(found.vertices, template.faces)
    there = ClosestPoint(scan).query(found.vertices)
    scan_normals = vertex_normals(scan.vertices, scan.faces)[scan.faces[there.faces, 0]]
    shown = (region > 0.5) & (trust > 0.9) & found.accepted
    assert (np.einsum("nd,nd->n", normals, scan_normals)[shown] > 0.5).mean() > 0.99
