"""One capture on the neutral's mesh: its settings, and whether it shows the neutral's person."""

import pytest

from blendshape_faces import face_mesh
from mien.blendshapes.align import stabilised
from mien.blendshapes.expression import RigConfig, check_person
from mien.errors import BadInput
from mien.faces import load_face
from mien.mesh import mass


def test_by_default_every_step_is_on():
    config = RigConfig()
    assert config.model
    assert config.stabilise
    assert config.masks
    assert config.warp.flow is not None
    assert config.complete.rounds > 0


def test_another_persons_capture_is_told_from_an_expression():
    face = load_face()
    neutral = face_mesh().vertices
    share = mass(neutral, face_mesh().faces) * face.regions["face"]

    def checked(found) -> None:
        check_person("smile", stabilised(found, neutral, share).apply(found), neutral, share)

    strong = {"jawOpen": 0.8, "browInnerUp": 1.0, "mouthSmileLeft": 1.0, "mouthSmileRight": 1.0}
    checked(face_mesh(**strong).vertices)
    larger = neutral * [1.14, 0.94, 1.08]
    with pytest.raises(BadInput, match=r"smile: .* another person"):
        checked(larger)
