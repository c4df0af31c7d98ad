"""`mien select`."""

import json

import pytest

from command import mien
from grey_film import film
from mien.errors import BadInput
from mien.io.markers import write_c3d
from test_scans_select_take_selection import recorded


def test_the_command_writes_list_study_and_sheet(tmp_path, capsys):
    take, _ = recorded(markers=16)
    write_c3d(tmp_path / "take.c3d", take)
    film(tmp_path / "f.mp4", 30)
    mien(
        "select",
        tmp_path / "take.c3d", output=tmp_path / "s.json", tolerance=1e-6, max_frames=3, spare_markers=True,
        video=tmp_path / "f.mp4", video_offset=0.2, units="mm",
    )  # fmt: skip
    content = json.loads((tmp_path / "s.json").read_text())
    assert len(content["frames"]) == len(content["errors"]) == 3
    assert content["take"] == "take.c3d"
    assert len(content["markers"]["spare_first"]) == 4
    assert (tmp_path / "s.png").stat().st_size > 100
    printed = capsys.readouterr().out
    assert "3 frames to scan" in printed
    assert "frames  mean, mm  % of diagonal  strongest tenth, %\n     1 " in printed
    assert "the mean alone is not met either" in printed
    assert len(content["strongest"]) == 3


def test_nothing_is_written_where_the_film_is_too_short(tmp_path):
    take, _ = recorded()
    write_c3d(tmp_path / "take.c3d", take)
    film(tmp_path / "f.mp4", 2)
    with pytest.raises(BadInput, match="--video-offset"):
        mien("select", tmp_path / "take.c3d", output=tmp_path / "s.json", tolerance=1e-6, video=tmp_path / "f.mp4")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["f.mp4", "take.c3d"]


@pytest.mark.parametrize("option", ["video_offset", "sheet"])
def test_options_of_a_film_are_refused_without_one(tmp_path, option):
    with pytest.raises(BadInput, match=f"--{option.replace('_', '-')} does nothing without --video"):
        mien("select", tmp_path / "take.c3d", **{option: 1})
