"""What the marker commands are told."""

import numpy as np
import pytest

from marker_stage import held
from mien.clip import Markers
from mien.errors import BadInput
from mien.faces import load_face
from mien.markers.attachment_file import write_attachment
from mien.markers.inputs import face_from_rig, read_placement, with_neutral
from mien.markers.pipeline import TakeConfig


@pytest.mark.parametrize(("told", "frame"), [("120", 120), ("2.5s", 150), ("0.5", 30), (" 3S ", 180)])
def test_neutral_is_a_frame_or_a_time(told, frame):
    assert with_neutral(TakeConfig(), told, 60.0).calibrate.neutral.frame == frame


def test_anything_else_is_refused():
    with pytest.raises(BadInput, match="--neutral"):
        with_neutral(TakeConfig(), "later", 60.0)


def test_a_rig_of_one_person_has_nobody_else_in_it():
    face = face_from_rig(load_face().rig)
    assert len(face.identity.modes) == 0
    assert face.regions is load_face().regions


def test_markers_placed_off_the_face_are_left_out_of_the_take(tmp_path):
    labels = tuple(f"m{i}" for i in range(60))
    write_attachment(tmp_path / "a.json", labels, held(), off_face=("cap",))
    markers, places = read_placement(
        tmp_path / "a.json", Markers(np.zeros((2, 61, 3)), ("cap", *labels), 60.0), load_face()
    )
    assert markers.labels == labels
    np.testing.assert_array_equal(places.faces, held().faces)
