"""Shape names in other spellings."""

import re

import numpy as np
import pytest

from mien.faces.arkit import ARKIT_NAMES
from mien.rig.facs import FACS23
from mien.rig.shape_names import match_names


def sided(name: str, left: str, right: str) -> str:
    return re.sub("Right$", right, re.sub("Left$", left, name))


def ahead(name: str) -> str:
    for side in ("Left", "Right"):
        if name.endswith(side):
            return f"{side[0]}_{name.removesuffix(side)}"
    return name


SPELLINGS = {
    "capital": lambda n: n[0].upper() + n[1:],
    "lower": str.lower,
    "upper": str.upper,
    "snake": lambda n: re.sub("([A-Z])", r"_\1", n).lower(),
    "blanks": lambda n: re.sub("([A-Z])", r" \1", n),
    "maya": lambda n: f"blendShape1.{n}",
    "namespace": lambda n: f"actor:head|{n}",
    "prefix": lambda n: f"bs_{n}",
    "prefix of a part": lambda n: f"mouth_{n}",
    "both ends": lambda n: f"head_{n}_geo",
    "copy": lambda n: f"{n}.001",
    "_L": lambda n: sided(n, "_L", "_R"),
    ".L": lambda n: sided(n, ".L", ".R"),
    "L": lambda n: sided(n, "L", "R"),
    "l": lambda n: sided(n.replace("Left", "L").replace("Right", "R"), "L", "R").lower(),
    "Lf": lambda n: sided(n, "_Lf", "_Rt"),
    "side first": ahead,
}


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_all_52_in_other_spellings_either_way(spelling):
    other = [SPELLINGS[spelling](name) for name in ARKIT_NAMES]
    for sources, targets in ((ARKIT_NAMES, other), (other, ARKIT_NAMES)):
        match = match_names(sources, targets)
        np.testing.assert_array_equal(match.share, np.eye(52))
        told = {pair for pair in zip(targets, sources, strict=True) if pair[0] != pair[1]}
        assert set(match.loose) == told


def driven(*targets: str) -> dict[str, dict[str, float]]:
    """What drives each target, where something does."""
    match = match_names(ARKIT_NAMES, targets)
    rows = {t: {ARKIT_NAMES[i]: float(column[i]) for i in np.flatnonzero(column)} for t, column in
            zip(targets, match.share.T, strict=True)}  # fmt: skip
    return {target: row for target, row in rows.items() if row}


def test_what_is_no_shape_of_ours_is_left_alone():
    names = (
        "A",
        "Basis",
        "eyeBlinkLeft_jawOpen",
        "corrective_jawOpen",
        "jawOpen_over",
        "mouth_raise_L",
    )
    assert driven(*names) == {}


def test_other_systems_words():
    assert driven("vrc.v_aa", "Fcl_EYE_Close_R", "Eye_Left_Wide", "MouthClosed") == {
        "vrc.v_aa": {"jawOpen": 1}, "Fcl_EYE_Close_R": {"eyeBlinkRight": 1}, "Eye_Left_Wide": {"eyeWideLeft": 1},
        "MouthClosed": {"mouthClose": 1},
    }  # fmt: skip


def test_one_shape_for_both_sides_and_two_for_one():
    assert driven("Mouth Smile")["Mouth Smile"] == {"mouthSmileLeft": 0.5, "mouthSmileRight": 0.5}
    both = driven("browInnerUp_L", "browInnerUp_R")
    assert list(both.values()) == [{"browInnerUp": 1.0}] * 2


def test_the_plainest_spelling_wins_and_twins_share():
    assert set(driven("jawOpen", "bs_jawOpen")) == {"jawOpen"}
    assert set(driven("head.jawOpen", "beard.jawOpen")) == {"head.jawOpen", "beard.jawOpen"}


def test_merged_shapes_and_their_parts_speak_to_one_another():
    parts = FACS23["browDown"]
    match = match_names(("browDown",), parts)
    np.testing.assert_array_equal(match.weights(np.array([[0.8]])), [[0.8, 0.8]])
    np.testing.assert_allclose(match_names(parts, ("browDown",)).weights(np.array([[0.8, 0.4]])), [[0.6]])


def test_pairs_by_hand_go_first_in_either_order():
    given = {"jawOpen": "Mund", "Blink": "eyeBlinkLeft", "nobody": "nothing"}
    match = match_names(("jawOpen", "eyeBlinkLeft"), ("Mund", "jaw_open", "Blink"), given)
    np.testing.assert_array_equal(match.share, [[1, 0, 0], [0, 0, 1]])


def test_lines_tell_of_loose_and_missing_names():
    lines = match_names(("jawOpen", "tongueOut"), ("Jaw_Open",)).notes()
    assert lines == [
        "1 shape names matched loosely: Jaw_Open = jawOpen",
        "1 of 2 shapes matched; missing: tongueOut",
    ]
    assert match_names(("jawOpen",), ("jawOpen",)).notes() == []
