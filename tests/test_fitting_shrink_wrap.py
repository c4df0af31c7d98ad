"""The fitted face onto a surface, everything hidden along with it."""

import numpy as np

from mien.faces.bundled import load_face
from mien.fitting.shrink_wrap import WrapStage, shrink_wrap
from mien.fitting.template_parts import TemplateParts
from mien.mesh import Mesh, closest_point
from mien.register.correspond import Rejection, Surface
from mien.register.nonrigid import NonrigidConfig


def test_the_skin_comes_to_lie_on_the_surface_and_eyes_and_teeth_go_along():
    face = load_face()
    parts, start = TemplateParts(face), face.rig.neutral
    pushed = start.vertices + np.array([0.0, 1.0, 3.0])
    surface = Surface(Mesh(pushed[parts.skin], parts.skin_triangles))
    stage = WrapStage(NonrigidConfig(closest=(0.5, 2.0), coarse=(), rejection=Rejection(max_distance=8.0)))
    trust = parts.trusted(1.0)
    found = shrink_wrap(face, parts, start, surface, [stage], trust)
    shown = np.flatnonzero((face.regions["face"] > 0.5) & (trust > 0))
    assert closest_point(surface.mesh, found.vertices[shown]).distances.mean() < 0.1
    assert closest_point(surface.mesh, start.vertices[shown]).distances.mean() > 1.0
    for name in ("left_eye", "upper_teeth"):
        moved = (found.vertices - start.vertices)[face.parts[name]]
        assert moved[:, 2].mean() > 1.5
        assert np.ptp(moved[:, 2]) < 1.5


def test_without_stages_the_shown_skin_stays():
    face = load_face()
    parts, start = TemplateParts(face), face.rig.neutral
    surface = Surface(Mesh(start.vertices[parts.skin], parts.skin_triangles))
    trust = parts.trusted(1.0)
    found = shrink_wrap(face, parts, start, surface, [], trust)
    skin = parts.skin[trust[parts.skin] > 0]
    np.testing.assert_allclose(found.vertices[skin], start.vertices[skin], atol=1e-9)
