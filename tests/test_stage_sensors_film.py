"""Films: what the camera delivers is the truth seen from where the truth says, hands and walks included."""

from dataclasses import replace

import numpy as np
import pytest

from mien.camera import Camera
from mien.depth import unproject
from mien.errors import BadInput
from mien.mesh import Mesh, closest_point
from mien.stage import FilmConfig, HeadMotion, film, make_performer, random_performance, structured_light
from mien.stage.sensors.film import lens_distorted

SENSOR = replace(structured_light(), camera=Camera(145.0, 145.0, 79.5, 59.5, 160, 120))
PERFECT = replace(
    SENSOR, noise=0.0, ripple=0.0, disparity_step=0.0, baseline=0.0, grazing=0.0, flying=0.0, lost=0.0, dark=0.0
)


@pytest.fixture(scope="module")
def performer():
    return make_performer(7)


@pytest.fixture(scope="module")
def weights():
    return random_performance(30.0, 2.0, seed=1).weights


def test_perfect_depth_lies_on_the_true_face(performer, weights):
    staged = film(performer, weights[[5, 40]], config=FilmConfig(sensor=PERFECT, wall=0.0))
    for i, frame in enumerate(staged.take):
        assert frame.depth is not None
        points = unproject(frame.depth, PERFECT.camera).reshape(-1, 3).astype(np.float64)
        middle = staged.truth.T_lab_face[i].apply(np.array([[0.0, -20.0, 90.0]]))[0]
        face = points[np.linalg.norm(points - middle, axis=1) < 60]
        true = staged.truth.T_lab_face[i].apply(staged.truth.vertices(np.array([i]))[0])
        assert len(face) > 100
        assert closest_point(Mesh(true, performer.neutral.faces), face).distances.max() < 1e-2


def test_the_face_is_coloured_where_it_is_near(performer, weights):
    staged = film(performer, weights[:1], config=FilmConfig(sensor=PERFECT))
    frame = next(iter(staged.take))
    assert frame.color is not None
    assert frame.depth is not None
    near = frame.depth < 800
    assert 0.05 < near.mean() < 0.7
    assert frame.color[near].std() > 15
    assert abs(frame.color[near].mean(axis=0) - frame.color[~near].mean(axis=0)).max() > 5


def test_every_walk_through_a_take_gives_the_same_frames(performer, weights):
    take = film(performer, weights[:3], config=FilmConfig(sensor=SENSOR)).take
    first, second = list(take), list(take)
    assert len(take) == len(first) == 3
    for a, b in zip(first, second, strict=True):
        np.testing.assert_array_equal(a.color, b.color)
        np.testing.assert_array_equal(a.depth, b.depth)
        assert a.time == b.time
    assert np.abs(first[0].depth.astype(float) - first[1].depth).max() > 0


def test_a_still_head_is_still_but_for_the_sensor(performer):
    config = FilmConfig(sensor=PERFECT, head=HeadMotion(rotation=0.0, translation=0.0), colour_noise=0.0)
    a, b = list(film(performer, np.zeros((2, 52)), config=config).take)
    np.testing.assert_array_equal(a.color, b.color)
    np.testing.assert_array_equal(a.depth, b.depth)


def test_a_hand_comes_before_the_face_and_goes(performer):
    config = FilmConfig(sensor=PERFECT, occlusions=((0.5, 0.3),), head=HeadMotion(rotation=0.0, translation=0.0))
    staged = film(performer, np.zeros((15, 52)), 10.0, config)
    depths = [frame.depth for frame in staged.take]
    middle = (slice(45, 75), slice(65, 95))
    assert depths[6][middle].mean() < depths[0][middle].mean() - 40
    np.testing.assert_allclose(depths[14], depths[0])
    assert staged.truth.in_view is not None
    assert staged.truth.in_view[0]
    assert not staged.truth.in_view[6]
    assert staged.truth.in_view[14]


def test_the_head_leaves_the_picture_and_returns(performer):
    config = FilmConfig(sensor=PERFECT, absences=((0.5, 0.4),))
    staged = film(performer, np.zeros((16, 52)), 10.0, config)
    x = staged.truth.T_lab_face.translation[:, 0]
    assert x[7] > x[0] + 400
    assert abs(x[-1]) < 80
    depths = [frame.depth for frame in staged.take]
    assert (depths[7][:60] < 800).mean() < 0.02 < (depths[0][:60] < 800).mean()


def test_the_projector_leaves_a_shadow_on_the_wall_at_one_side(performer):
    config = FilmConfig(sensor=replace(PERFECT, baseline=75.0), wall=900.0, head=HeadMotion(0.0, 0.0))
    frame = next(iter(film(performer, np.zeros((1, 52)), config=config).take))
    plain = next(iter(film(performer, np.zeros((1, 52)), config=replace(config, sensor=PERFECT)).take))
    assert frame.depth is not None
    assert plain.depth is not None
    gone = (frame.depth == 0) & (plain.depth == np.float32(900.0))
    head = np.nonzero(plain.depth[:60] < 800)[1].mean()
    assert gone.sum() > 50
    assert np.nonzero(gone[:60])[1].mean() > head


def test_impossible_stages_are_refused(performer, weights):
    with pytest.raises(BadInput, match="weights"):
        film(performer, weights[:, :-1])
    with pytest.raises(BadInput, match="distance"):
        film(performer, weights, config=FilmConfig(distance=300.0))


def test_late_depth_is_an_earlier_moments(performer, weights):
    head = HeadMotion(rotation=0.3, translation=40.0, seconds=0.3)
    plain, late = (
        list(film(performer, weights[:6], config=FilmConfig(sensor=PERFECT, head=head, depth_late=by)).take)
        for by in (0.0, 1 / 30)
    )
    np.testing.assert_allclose(late[4].depth, plain[3].depth, atol=1e-3)
    np.testing.assert_array_equal(late[4].color, plain[4].color)


def test_an_open_shutter_blurs_what_moves_and_nothing_else(performer, weights):
    moving, still = HeadMotion(rotation=0.4, translation=60.0, seconds=0.25), HeadMotion(rotation=0.0, translation=0.0)
    shots = {}
    for name, head in (("moving", moving), ("still", still)):
        for shutter in (0.0, 0.033):
            config = FilmConfig(sensor=PERFECT, head=head, shutter=shutter, colour_noise=0.0)
            frames = list(film(performer, np.zeros((4, 52)), config=config).take)
            shots[name, shutter] = frames[3].color.astype(float)
    still_change, moving_change = (
        np.abs(shots[name, 0.033] - shots[name, 0.0]).mean() for name in ("still", "moving")
    )
    assert still_change < 0.1
    assert moving_change > 2.0


def test_a_lens_bends_by_browns_formula():
    camera, k1 = PERFECT.camera, -0.2
    image = np.zeros((camera.height, camera.width))
    row, column = 20, 30
    image[row - 1 : row + 2, column - 1 : column + 2] = 1.0
    x, y = (column - camera.cx) / camera.fx, (row - camera.cy) / camera.fy
    factor = 1 + k1 * (x * x + y * y)
    found = np.argwhere(lens_distorted(image, camera, k1) > 0).mean(axis=0)
    expected = [camera.fy * y * factor + camera.cy, camera.fx * x * factor + camera.cx]
    np.testing.assert_allclose(found, expected, atol=0.8)
    np.testing.assert_array_equal(lens_distorted(image, camera, 0.0), image)


def test_what_is_worn_is_seen(performer, weights):
    still = HeadMotion(rotation=0.0, translation=0.0)
    bare, worn = (
        next(iter(film(performer, weights[:1], config=FilmConfig(sensor=PERFECT, head=still, worn=kinds)).take))
        for kinds in ((), ("glasses", "beard", "hair"))
    )
    changed = np.abs(worn.color.astype(int) - bare.color).max(axis=2) > 40
    assert changed.mean() > 0.01
    nearer = bare.depth - worn.depth
    assert (nearer[changed] > 1.0).mean() > 0.3
