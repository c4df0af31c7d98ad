"""Fields of muscles: what anatomy allows, by hand on the bundled face."""

import numpy as np
import pytest

from mien.faces.bundled import load_face
from mien.stage.people.anatomy import eyeball
from mien.stage.people.muscle_fields import SkinMap, jaw_share, lid_turns, pull_fields
from mien.stage.people.muscle_table import PULLS, Pull

LEFT_LEVATOR = PULLS["levatorLabii"]


@pytest.fixture(scope="module")
def face():
    return load_face()


@pytest.fixture(scope="module")
def where(face):
    return SkinMap(face.rig.neutral, face)


def pulled(where, pull: Pull):
    ends = (where.landmarks[mark] + np.array(offset) for mark, offset in (pull.origin, pull.insertion))
    return pull_fields(where, *ends, pull)


def test_a_pull_draws_its_insertion_towards_its_origin_and_leaves_the_origin(where):
    draw, _ = pulled(where, LEFT_LEVATOR)
    at = where.nearest(where.landmarks[[LEFT_LEVATOR.origin[0], LEFT_LEVATOR.insertion[0]]])
    assert draw[at[1], 1] > 0.4 * LEFT_LEVATOR.reach
    assert np.linalg.norm(draw[at[0]]) < 0.2 * LEFT_LEVATOR.reach


def test_a_pull_on_the_upper_lip_leaves_the_lower_lip_and_the_other_side_alone(where, face):
    draw, _ = pulled(where, LEFT_LEVATOR)
    size = np.linalg.norm(draw, axis=1)
    assert size[face.contours["upper_lip"]].max() > 2.0
    assert size[face.contours["lower_lip"][4:-4]].max() < 0.6
    assert size[where.mesh.vertices[:, 0] < -20].max() < 0.3


def test_a_belly_rises_outwards(where):
    _, bulge = pulled(where, PULLS["zygomaticus"])
    assert ((bulge * where.normals).sum(axis=1) > -0.1).all()
    assert np.linalg.norm(bulge, axis=1).max() > 0.5 * PULLS["zygomaticus"].bulge


def test_the_jaw_carries_the_chin_and_not_the_skull(where, face):
    share = jaw_share(where)
    chin, nose = where.nearest(where.landmarks[[152, 4]])
    assert share[chin] > 0.9
    assert share[nose] < 0.1
    assert share[where.face.on_skin & (where.mesh.vertices[:, 1] > 20)].max() < 0.05
    lips = [share[face.contours[f"{side}_lip"][3:-3]] for side in ("upper", "lower")]
    assert lips[0].max() < 0.35 < 0.65 < lips[1].min()


def test_lids_turn_on_the_ball(where, face):
    upper, _, angle = lid_turns(where, eyeball(face, where.mesh.vertices, "Left"), "Left")
    edge = face.contours["left_upper_lid"][2:-2]
    moved = where.mesh.vertices[edge] + np.sin(angle) * upper.first[edge] + (1 - np.cos(angle)) * upper.second[edge]
    assert (moved[:, 1] < where.mesh.vertices[edge, 1] - 1).all()
