"""What the marker commands are told."""

import pytest

from mien.errors import BadInput
from mien.faces import load_face
from mien.markers.inputs import face_from_rig, with_neutral
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
