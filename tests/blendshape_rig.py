"""A small rig built of painted faces with true landmarks, made once for all tests that look at it."""

from functools import cache
from unittest.mock import patch

import numpy as np

from blendshape_faces import face_landmarks, face_map
from mien.blendshapes import corrections
from mien.blendshapes.captures import Capture
from mien.blendshapes.correspond.dense import WarpConfig
from mien.blendshapes.correspond.landmarks import MapLandmarks
from mien.blendshapes.correspond.matches import MatchConfig
from mien.blendshapes.expression import RigConfig
from mien.blendshapes.pipeline import BuiltRig, build_rig
from mien.faces import load_face

QUICK = RigConfig(texture=128, warp=WarpConfig(matches=MatchConfig(rounds=1)))
JAW, SMILE = {"jawOpen": 0.7}, {"mouthSmileLeft": 0.9, "mouthSmileRight": 0.9}
SEEN = {"neutral": {}, "jawOpen": JAW, "grin": SMILE}


def true_landmarks(map_) -> MapLandmarks:
    """Landmarks of one of `SEEN`; a capture of another name shows none."""
    if map_.name in SEEN:
        return face_landmarks(**SEEN[map_.name])
    return MapLandmarks(face_landmarks().points, np.zeros(478, bool))


@cache
def built_rig() -> BuiltRig:
    """All 52 shapes from two captures; a third, `blind`, cannot be used."""
    captures = [Capture(face_map(name, **weights), "") for name, weights in SEEN.items()]
    captures.append(Capture(face_map("blind"), ""))
    with patch.object(corrections, "landmarks_on_map", true_landmarks):
        return build_rig(captures, "neutral", load_face(), True, QUICK)
