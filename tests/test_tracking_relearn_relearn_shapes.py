"""A take whose face smiles otherwise than its rig: the rig learns it from the picture, and nothing from a blank one."""

from dataclasses import replace
from functools import cache

import numpy as np

import relearn_stage
import tracking_stage as stage
from mien.depth import RGBDFrame
from mien.rgbd import RgbdTake
from mien.rig import Performance
from mien.tracking.correctives import with_correctives
from mien.tracking.relearn.front_chart import charted
from mien.tracking.relearn.node_grid import node_grid
from mien.tracking.relearn.relearn_shapes import (
    FirstPass,
    RelearnConfig,
    calm_numbers,
    evenly,
    picture_belief,
    relearn_shapes,
    slip_of,
)
from mien.tracking.relearn.shape_corrections import CorrectionConfig
from mien.tracking.relearn.shape_flow import ShapeFlowConfig, shape_flow
from mien.tracking.relearn.skin_look import calm_reference, normalised
from mien.transforms import Transform, stacked

FRAMES, SMILES = 12, ("mouthSmileLeft", "mouthSmileRight")
CONFIG = RelearnConfig(
    least=10, look=relearn_stage.CONFIG, flow=ShapeFlowConfig(node=2), corrections=CorrectionConfig(ridge=0.02)
)


def played():
    weights = np.zeros((FRAMES, 52))
    for name in SMILES:
        weights[:, stage.person().index(name)] = np.sin(np.linspace(0, 4.5 * np.pi, FRAMES)) ** 2
    return weights


@cache
def bent():
    """The person's own smile pulls the cheeks up by 3 mm more."""
    rig, m = stage.person(), stage.model()
    deltas = rig.deltas.copy()
    x, y = m.neutral[:, 0], m.neutral[:, 1]
    for name, side in zip(SMILES, (1, -1), strict=True):
        cheek = np.exp(-((x - 35 * side) ** 2 + (y - y.mean()) ** 2) / (2 * 15.0**2)) * m.fade
        deltas[rig.index(name), m.front, 1] += 3.0 * cheek
    return replace(rig, deltas=deltas)


@cache
def pictures():
    """The bent face's, and where it was."""
    poses = [stage.pose((0, 0.1 * np.sin(t / 5), 0), distance=500.0) for t in range(FRAMES)]
    return [relearn_stage.picture(bent(), w, T) for w, T in zip(played(), poses, strict=True)], poses


def first_pass(blank=False, colour=True, tracked=None):
    """The take of the bent rig as the plain one tracks it: with the right weights in the right places."""
    frames, (seen, poses) = [], pictures()
    for t, (color, depth) in enumerate(seen):
        shown = np.full_like(color, 120) if blank else color
        frames.append(RGBDFrame(shown if colour else None, depth, t / 30))
    take = RgbdTake("smile", relearn_stage.CAMERA, 30.0, FRAMES, True, lambda: iter(frames))
    told = np.ones(FRAMES, bool) if tracked is None else tracked
    performance = Performance(stage.person(), played(), stacked(poses), 30.0, told)
    return FirstPass(take, stage.model(), performance, played(), Transform.identity())


class Heard:
    """Progress that is written down."""

    def __init__(self):
        self.said = []

    def update(self, stage, done, total):
        self.said.append((done, total))


def test_a_shape_comes_nearer_to_how_the_person_makes_it():
    m, first, heard = stage.model(), first_pass(), Heard()
    found = relearn_shapes(first, CONFIG, heard)
    smile = [m.rig.index(name) for name in SMILES]  # played together: what is whose is not told
    plain, true, learnt = (rig.deltas[smile][:, m.front].sum(axis=0) for rig in (stage.person(), bent(), found))
    wanted = np.linalg.norm(true - plain, axis=1)
    off = np.linalg.norm(true - learnt, axis=1)
    moves = (wanted > 1.0) & relearn_stage.chart().shown
    assert off[moves].mean() < 0.6 * wanted[moves].mean()
    assert off[wanted < 0.2].mean() < 0.12
    assert heard.said == [(i + 1, FRAMES) for i in range(FRAMES)]
    np.testing.assert_array_equal(m.rig.deltas, stage.person().deltas)  # it stays as it was


def test_what_the_final_mesh_adds_to_a_shape_becomes_the_shape_s():
    """Correctives of the tracked take bulge the lip whenever the mouth smiles."""
    first, m = first_pass(), stage.model()
    smile = [m.rig.index(name) for name in SMILES]
    lip = m.neutral[:, 1] < m.neutral[:, 1].mean()
    bulge = np.zeros((1, len(m.front), 3))
    bulge[0, :, 2] = 2.0 * lip * m.fade
    weights = np.concatenate([played(), played()[:, smile[:1]]], axis=1)
    adds = replace(first.performance, rig=with_correctives(m.rig, m, bulge), weights=weights)
    found = relearn_shapes(replace(first, performance=adds), CONFIG)
    added = found.deltas[smile][:, m.front].sum(axis=0) - m.rig.deltas[smile][:, m.front].sum(axis=0)
    inner = m.fade == 1
    low = m.neutral[:, 1] < m.neutral[:, 1].mean() - 15
    np.testing.assert_allclose(np.median(added[inner & low, 2]), 2.0, atol=0.2)


def test_a_blank_face_no_picture_or_too_few_frames_leave_the_rig_as_it_is():
    assert relearn_shapes(first_pass(blank=True), CONFIG) is stage.model().rig
    assert relearn_shapes(first_pass(colour=False), CONFIG) is stage.model().rig
    assert relearn_shapes(first_pass(), RelearnConfig(least=FRAMES + 1)) is stage.model().rig
    assert relearn_shapes(first_pass(), RelearnConfig(frames=0, least=10)) is stage.model().rig
    assert relearn_shapes(first_pass(tracked=np.zeros(FRAMES, bool)), CONFIG) is stage.model().rig


def test_calm_frames_are_those_in_which_the_face_moves_least():
    first = first_pass()
    size = first.fitted.sum(axis=1)
    found = calm_numbers(first, np.arange(2, FRAMES), 4)
    assert (np.diff(found) > 0).all()
    assert size[found].max() <= np.sort(size[2:])[3] + 1e-12


def test_slip_is_how_far_the_model_is_off_its_skin():
    m, chart, look = stage.model(), relearn_stage.chart(), relearn_stage.CONFIG
    T, neutral = stage.pose(distance=500.0), m.neutral.astype(float)
    color, depth = relearn_stage.picture(stage.person(), np.zeros(52), T)
    rest, off = (
        charted(chart, color, depth, relearn_stage.CAMERA, T, neutral + shift)
        for shift in (np.zeros(3), np.array([1.5, -0.8, 0]))
    )
    reference = calm_reference([rest], look)
    pictures = [normalised(frame.grey, look) for frame in (rest, off)]
    found = shape_flow(pictures, reference, np.array([[0.0], [1.0]]), CONFIG.flow)
    assert np.abs(slip_of(chart, rest.surface, found.of_frame(0))).max() < 1e-6
    slip = slip_of(chart, off.surface, found.of_frame(1))
    there = slip.any(axis=1)
    assert there[chart.shown].mean() > 0.7
    assert not there[~chart.shown].any()
    np.testing.assert_allclose(np.median(slip[there, :2], axis=0), [-1.5, 0.8], atol=0.15)


def test_flow_is_believed_where_pictures_come_to_agree_by_it():
    grid = node_grid(np.ones((400, 8), bool), 4)
    before = np.full(int(grid.there.sum()), 2.0)
    row = np.nonzero(grid.there)[0]
    after = np.where(row < 50, 0.97, 0.8) * before  # by 3 % above, by a fifth below
    found = picture_belief(grid, before, after, CONFIG)[0]
    assert not found[:100].any()
    np.testing.assert_allclose(found[300:], 1.0, atol=1e-6)
    assert (np.diff(found[:, 4]) >= -1e-6).all()


def test_frames_are_taken_evenly():
    np.testing.assert_array_equal(evenly(np.arange(3, 13), 4), [3, 6, 9, 12])
    np.testing.assert_array_equal(evenly(np.arange(3), 30), [0, 1, 2])
