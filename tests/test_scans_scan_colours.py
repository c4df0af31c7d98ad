"""The scans' colours on the rig."""

from dataclasses import replace

import numpy as np

from mien.faces import load_face
from mien.mesh import Mesh, submesh
from mien.scans.scan_colours import rig_colours
from mien.scans.scan_rig import rig_of_scans
from small_scans import bundled_template, front_of

BROWN = np.array([0.42, 0.27, 0.18])


def painted(mesh: Mesh, exposure: float = 1.0) -> Mesh:
    """Brown skin, redder to the subject's left."""
    left = mesh.vertices[:, :1] / 200
    return replace(mesh, colors=np.clip(exposure * (BROWN + left * [1.0, 0.0, 0.0]), 0, 1))


def without(mesh: Mesh, place: np.ndarray, reach: float) -> Mesh:
    away = np.linalg.norm(mesh.vertices - place, axis=1) > reach
    return submesh(mesh, np.flatnonzero(away[mesh.faces].all(axis=1)))[0]


def test_a_brown_actor_stays_brown_where_a_scan_shows_them_and_where_none_does():
    template = bundled_template()
    skin = template.skin
    smile = load_face().rig.deltas[load_face().rig.index("mouthSmileLeft")][template.members]
    cheek = skin.vertices[np.argmax(skin.vertices[:, 2])] + np.array([25.0, 0.0, 0.0])
    rest = without(painted(front_of(skin)), cheek, 12.0)
    other = painted(front_of(skin.with_vertices(skin.vertices + smile)), exposure=1.5)
    shapes = np.stack([skin.vertices, skin.vertices + smile])
    colours = rig_colours(template, shapes, [rest, other])
    assert colours is not None
    on_face = template.members[template.regions["face"] > 0.5]
    true = painted(template.mesh).colors[on_face]
    np.testing.assert_allclose(colours[on_face], true, atol=0.05)
    scalp = template.members[skin.vertices[:, 2] < -60]
    np.testing.assert_allclose(colours[scalp].mean(axis=0), BROWN, atol=0.15)
    teeth = template.parts["lower_teeth"]
    np.testing.assert_array_equal(colours[teeth], template.mesh.colors[teeth])
    rig = rig_of_scans(template, shapes, ["rest", "smile"], colours)
    np.testing.assert_array_equal(rig.neutral.colors, colours)


def test_scans_without_colours_leave_the_template_s():
    template = bundled_template()
    bare = replace(front_of(template.skin), colors=None)
    assert rig_colours(template, template.skin.vertices[None], [bare]) is None
    rig = rig_of_scans(template, template.skin.vertices[None], ["rest"], None)
    np.testing.assert_array_equal(rig.neutral.colors, template.mesh.colors)
