"""From a recorded take to selection.json, and the command."""


import numpy as np
import pytest

from mien.clip import Markers
from mien.errors import BadInput
from mien.scans.select.select_frames import SelectConfig, select_frames
from mien.scans.select.take_selection import SelectTakeConfig, read_selection, select_take, write_selection
from mien.transforms import Transform, rotation_from_vector
from test_scans_select_select_frames import low_rank_take

FOUR = SelectTakeConfig(select=SelectConfig(tolerance=1e-9, max_frames=4))


def recorded(seed=0, frames=60, markers=12):
    """A take in the lab with a moving head, and the face motion behind it."""
    face = low_rank_take(seed, frames, markers)
    t = np.linspace(0, 3, frames)[:, None]
    T = Transform(rotation_from_vector(0.2 * np.sin(t + np.arange(3))), 100 * np.cos(t * [1, 2, 3]))
    return Markers(T.apply(face), tuple(f"m{i}" for i in range(markers)), 30.0), face


def test_head_motion_makes_no_difference():
    take, face = recorded()
    found = select_take(take, FOUR)
    still = select_take(take.with_positions(face), FOUR)
    np.testing.assert_array_equal(found.selection.frames, still.selection.frames)
    np.testing.assert_allclose(found.selection.errors, still.selection.errors, rtol=1e-2)


def test_frames_count_in_the_take_where_frames_are_left_out():
    take, _ = recorded()
    whole = select_take(take, FOUR)
    holed = take.positions.copy()
    missing = np.setdiff1d(np.arange(5, 20), whole.selection.frames)
    holed[missing] = np.nan
    found = select_take(take.with_positions(holed), FOUR)
    assert not set(missing) & set(found.analysed.tolist())
    assert set(found.selection.frames.tolist()) <= set(found.analysed.tolist())
    again = select_frames(found.positions, FOUR.select)
    np.testing.assert_array_equal(again.frames, found.bases)


def test_a_marker_that_is_seldom_seen_is_left_out_and_named():
    take, _ = recorded()
    holed = take.positions.copy()
    holed[:40, 3] = np.nan
    holed[7:9, 5] = np.nan
    found = select_take(take.with_positions(holed), FOUR)
    assert found.left_out == ("m3",)
    assert found.positions.shape == (60, 11, 3)
    assert np.isfinite(found.positions).all()


def test_takes_with_too_little_in_them_are_named():
    take, _ = recorded()
    with pytest.raises(BadInput, match="no marker is seen in 50%"):
        select_take(take.with_positions(np.full(take.positions.shape, np.nan)), FOUR)
    holed = np.full(take.positions.shape, np.nan)
    holed[10] = take.positions[10]
    with pytest.raises(BadInput, match="only 1 frame"):
        select_take(take.with_positions(holed), FOUR)


def test_stretches_without_any_marker_do_not_count_against_the_markers():
    take, _ = recorded()
    holed = take.positions.copy()
    holed[::2] = np.nan
    found = select_take(take.with_positions(holed), FOUR)
    assert found.left_out == ()
    np.testing.assert_array_equal(found.analysed, np.arange(1, 60, 2))


def test_file_round_trip(tmp_path):
    take, _ = recorded()
    found = select_take(take, FOUR)
    write_selection(tmp_path / "s.json", "take.c3d", found)
    back = read_selection(tmp_path / "s.json")
    assert list(back.frames) == found.selection.frames.tolist()
    np.testing.assert_allclose(back.errors, found.selection.relative, atol=1e-7)
    assert (back.tolerance, back.take) == (1e-9, "take.c3d")


def test_a_list_of_frames_by_hand_is_enough(tmp_path):
    (tmp_path / "s.json").write_text('{"frames": [3, 1]}')
    assert read_selection(tmp_path / "s.json").frames == (3, 1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("frames", "not a JSON file"),
        ("[1, 2]", "expected"),
        ('{"frames": []}', "expected"),
        ('{"frames": [1.5]}', "expected"),
        ('{"frames": [-1]}', "expected"),
        ('{"frames": [1, 1]}', "listed twice"),
        ('{"frames": [1], "tolerance": "low"}', "expected"),
    ],
)
def test_selection_files_that_cannot_be_are_named(tmp_path, text, message):
    (tmp_path / "s.json").write_text(text)
    with pytest.raises(BadInput, match=message):
        read_selection(tmp_path / "s.json")
