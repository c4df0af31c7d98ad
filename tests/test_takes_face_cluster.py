"""Which markers are one face."""

from dataclasses import replace

import numpy as np
import pytest

from marker_stage import held, motion
from mien.clip import Markers
from mien.errors import BadInput
from mien.faces import load_face
from mien.takes.face_cluster import find_face

FRAMES = 60
PLACE = np.array([0.0, 1500, 0])


def take(parts: dict[str, np.ndarray], rate: float = 60.0) -> Markers:
    """Named groups of paths (frames, k, 3) as one take."""
    labels = tuple(f"{name}{i}" for name, X in parts.items() for i in range(X.shape[1]))
    return Markers(np.concatenate(list(parts.values()), axis=1), labels, rate)


def face(seed: int = 0) -> np.ndarray:
    """Thirty markers on a face that turns and sways."""
    points = held().points(load_face().rig.neutral)[::2]
    return motion(FRAMES, seed, angle=0.15).apply(np.repeat(points[None], FRAMES, axis=0)) + PLACE


def body() -> np.ndarray:
    """A dozen markers down a body whose limbs swing."""
    rng = np.random.default_rng(1)
    places = np.stack([rng.uniform(-250, 250, 12), np.linspace(0, 1150, 12), rng.uniform(-100, 100, 12)], 1)
    swing = np.sin(np.arange(FRAMES) / 6 + np.arange(12)[:, None]).T[..., None] * [0, 20, 150]
    return places + swing


def test_a_face_alone_keeps_everything():
    found = find_face(take({"f": face()}))
    assert found.kept.tolist() == list(range(30))
    assert found.lines == ()


def test_a_face_is_found_beside_a_body_and_the_rest_is_named():
    found = find_face(take({"b": body(), "f": face()}))
    assert set(found.markers.labels) == {f"f{i}" for i in range(30)}
    assert "b0" in found.lines[0]
    assert "--markers" in found.lines[0]


def test_a_stray_prop_and_a_second_actor_are_left_out():
    wand = np.repeat(np.array([[[900.0, 1400, 300]]]), FRAMES, axis=0)
    other = face(3)[:, :20] + [1200.0, 0, 0]
    found = find_face(take({"f": face(), "w": wand, "o": other}))
    assert set(found.markers.labels) == {f"f{i}" for i in range(30)}
    assert any("another group as large as a face" in line and "o0" in line for line in found.lines)
    assert any("w0" in line for line in found.lines)


def test_a_marker_that_stands_in_the_room_while_the_head_passes_is_left_out():
    X = face()
    still = np.repeat(X[:1, :1] + [0.0, 0, 15], FRAMES, axis=0)
    found = find_face(take({"f": X, "b": body(), "s": still}))
    assert "s0" not in found.markers.labels


@pytest.mark.parametrize("count", [2, 3, 6])
def test_a_prop_of_several_markers_before_the_face_is_left_out(count):
    """A microphone's markers stay near one another while the head passes."""
    X = face()
    prop = X[:1, :1] + [0.0, -30, 40] + 15.0 * np.random.default_rng(2).normal(size=(1, count, 3))
    found = find_face(take({"f": X, "p": np.repeat(prop, FRAMES, axis=0)}))
    assert set(found.markers.labels) == {f"f{i}" for i in range(30)}


def test_labels_never_seen_and_hardly_seen_are_no_part_of_it():
    X = np.concatenate([face(), np.full((FRAMES, 2, 3), np.nan)], axis=1)
    X[3, 31] = X[3, 0]
    found = find_face(take({"f": X}))
    assert found.kept.tolist() == list(range(30))
    assert found.lines == ("seen too seldom and left out: f31",)


@pytest.mark.parametrize("shown", [0, 2, 5])
def test_too_few_markers_are_refused(shown):
    X = face()
    X[:, shown:] = np.nan
    with pytest.raises(BadInput, match="no face"):
        find_face(take({"f": X}))


def test_a_body_without_a_face_is_refused():
    with pytest.raises(BadInput, match=r"no face.*--markers"):
        find_face(take({"b": body()}))


@pytest.mark.parametrize("unit_mm", [10.0, 12.0])
def test_a_body_in_another_unit_is_no_face_though_it_has_its_size(unit_mm):
    """172 cm and 172 mm are one number: limbs swing, faces do not."""
    people = np.concatenate([body(), body() + np.array([60, 40, 30])], axis=1) / unit_mm
    with pytest.raises(BadInput, match=r"a quarter of its 24 markers usually lie .* % of its size or more"):
        find_face(take({"b": people}))


def test_a_rate_that_is_none_is_refused():
    with pytest.raises(BadInput, match="rate"):
        find_face(replace(take({"f": face()}), rate=float("nan")))


def test_a_rigid_body_on_a_helmet_stays_with_the_face_it_moves_with():
    helmet = np.array([[x, y, z] for x in (-30.0, 30) for y in (110.0, 170, 230) for z in (-210.0, -140, -70, 0)])
    T = motion(FRAMES, 0, angle=0.15)
    found = find_face(take({"f": face(), "h": T.apply(np.repeat(helmet[None], FRAMES, axis=0)) + PLACE}))
    assert len(found.kept) == 54
