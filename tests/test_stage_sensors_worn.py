"""Hair, beards and glasses: where they belong, and nowhere else."""

import numpy as np
import pytest

from mien.stage import make_performer
from mien.stage.people.skin import face_map
from mien.stage.sensors.worn import HAIR_LENGTH, beard_hair, wear


@pytest.fixture(scope="module")
def performer():
    return make_performer(3)


def test_a_beard_grows_on_the_chin_and_not_on_lips_nose_or_forehead(performer):
    where = face_map(performer)
    spots = np.stack([where.chin, where.mouth.mean(axis=0), where.wing.mean(axis=0), where.eye.mean(axis=0)])
    height = beard_hair(performer, spots, 6.0, np.random.default_rng(0))
    assert height[0] > 1.5
    assert height[1:].max() < 0.3
    assert not beard_hair(performer, spots, 0.0, np.random.default_rng(0)).any()


@pytest.mark.parametrize("kind", ["hair", "beard"])
def test_hair_goes_with_the_skin(performer, kind):
    worn = wear(performer, kind)
    opened = performer.vertices(np.eye(52)[[performer.names.index("jawOpen")]])[0]
    off = np.linalg.norm(worn.vertices(opened, performer.neutral.faces) - opened[worn.rows], axis=1)
    np.testing.assert_allclose(off, worn.height, atol=1e-9)
    assert 0.3 < off.max() <= 1.6 * HAIR_LENGTH[kind]
    eyes = face_map(performer).eye.mean(axis=0)[1]
    above = worn.mesh.vertices[:, 1] > eyes
    assert above.mean() > 0.9 if kind == "hair" else not above.any()


def test_glasses_stand_before_the_eyes_and_on_the_skull(performer):
    worn = wear(performer, "glasses")
    for ball in performer.eyes.values():
        near = worn.mesh.vertices[np.linalg.norm((worn.mesh.vertices - ball.centre)[:, :2], axis=1) < 30]
        assert near[:, 2].max() > ball.centre[2] + ball.radius + 5
    placed = worn.vertices(performer.neutral.vertices, performer.neutral.faces)
    np.testing.assert_array_equal(placed, worn.mesh.vertices)


def test_a_headset_hides_eyes_and_brows_and_leaves_the_mouth(performer):
    box, where = wear(performer, "headset").mesh.vertices, face_map(performer)
    assert box[:, 2].max() > max(ball.centre[2] + ball.radius for ball in performer.eyes.values()) + 30
    assert where.mouth[:, 1].max() < box[:, 1].min() < where.eye[:, 1].min()
    assert np.abs(box[:, 0]).max() > 60
