"""The chart of a face's front: what lies where, and what of a picture is not believed."""

import numpy as np

import relearn_stage
import tracking_stage as stage
from mien.image_space.layout import sampled
from mien.tracking.relearn.front_chart import charted


def test_a_vertex_lies_where_the_chart_says_and_is_shown_once():
    chart, neutral = relearn_stage.chart(), stage.model().neutral.astype(float)
    assert 0.3 < chart.shown.mean() < 0.9
    drawn = sampled(chart.drawn(neutral), chart.uv)
    np.testing.assert_allclose(drawn[chart.shown, :2], neutral[chart.shown, :2], atol=0.05)
    assert np.abs(drawn[chart.shown, 2] - neutral[chart.shown, 2]).max() < 2.5  # creases are flattened, no more


def test_pictures_are_read_where_the_skin_is_whatever_the_pose():
    m, chart = stage.model(), relearn_stage.chart()
    T = stage.pose((0.1, 0.25, 0.05), (5, 3, 0), 500.0)
    color, depth = relearn_stage.picture(stage.person(), np.zeros(52), T)
    found = charted(chart, color, depth, relearn_stage.CAMERA, T, m.neutral.astype(float)).grey
    expected = relearn_stage.look(chart.drawn(m.neutral.astype(float)))
    seen = np.isfinite(found)
    assert seen.mean() > 0.5 * chart.inside.mean()
    assert np.corrcoef(found[seen], expected[seen])[0, 1] > 0.95


def test_what_is_turned_away_hidden_or_outside_is_not_read():
    m, chart = stage.model(), relearn_stage.chart()
    neutral, camera = m.neutral.astype(float), relearn_stage.CAMERA
    color, depth = relearn_stage.picture(stage.person(), np.zeros(52), stage.pose(distance=500.0))
    seen = charted(chart, color, depth, camera, stage.pose(distance=500.0), neutral)
    x = seen.surface[..., 0]
    behind = np.where(np.arange(camera.width) < 160, depth - 100, depth)  # a hand before the half on the left
    hidden = charted(chart, color, behind.astype(np.float32), camera, stage.pose(distance=500.0), neutral).grey
    assert not np.isfinite(hidden[x < -2]).any()
    np.testing.assert_array_equal(hidden[x > 2], seen.grey[x > 2])
    turned = charted(chart, color, None, camera, stage.pose((0, 1.2, 0), distance=500.0), neutral).grey
    assert np.isfinite(turned).sum() < 0.6 * np.isfinite(seen.grey).sum()
    out = charted(chart, color, None, camera, stage.pose(shift=(130, 0, 0), distance=500.0), neutral).grey
    assert 0 < np.isfinite(out).sum() < 0.6 * np.isfinite(seen.grey).sum()
