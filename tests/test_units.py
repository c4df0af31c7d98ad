"""Which unit a file is in: told, written, or given away by its size."""

import numpy as np
import pytest

from marker_files import FACE, NAMES, custom_c3d, refusal, take, wide_csv
from mien.io.markers import read_marker_file, read_markers
from mien.units import face_cluster, known_unit, largest_cluster


@pytest.mark.parametrize(("unit", "mm"), [("mm", 1), ("cm", 10), ("m", 1000), ("in", 25.4)])
def test_each_unit_of_a_c3d(tmp_path, unit, mm):
    path = custom_c3d(tmp_path / "take.c3d", list(NAMES), np.tile(FACE, (3, 1, 1)) / mm, units=(unit,))
    np.testing.assert_allclose(read_markers(path).positions[0], FACE, rtol=1e-5)


@pytest.mark.parametrize(
    ("unit", "scale", "size", "better"), [("m", 1.0, "174 m ", "--units mm"), ("mm", 1e-3, "0.17 mm", "--units m ")]
)
def test_a_stated_unit_that_makes_no_face_names_the_right_one(tmp_path, unit, scale, size, better):
    path = custom_c3d(tmp_path / "take.c3d", list(NAMES), np.tile(FACE, (3, 1, 1)) * scale, units=(unit,))
    line = refusal(path)
    assert size in line
    assert better in line
    np.testing.assert_allclose(read_markers(path, unit=better.split()[1]).positions[0], FACE, rtol=1e-5)


@pytest.mark.parametrize(("scale", "unit"), [(1.0, 1.0), (0.1, 10.0), (1e-3, 1000.0)])
def test_an_unstated_unit_is_the_one_that_makes_a_face(tmp_path, scale, unit):
    read = read_marker_file(wide_csv(tmp_path / "take.csv", take().positions * scale))
    assert (read.unit_mm, read.unit_source) == (unit, "assumed")
    assert "no unit named" in read.warnings[0]


def test_an_unheard_of_unit_is_guessed_from_the_size(tmp_path):
    read = read_marker_file(wide_csv(tmp_path / "take.csv", take().positions / 184.84))
    assert read.unit_source == "guessed"
    span = np.nanmedian(np.linalg.norm(np.ptp(read.markers.positions, axis=1), axis=1))
    np.testing.assert_allclose(span, 140, rtol=1e-3)
    assert "guess" in read.warnings[0]


def test_a_number_is_a_unit(tmp_path):
    path = wide_csv(tmp_path / "take.csv", take().positions / 184.84)
    np.testing.assert_allclose(read_markers(path, unit="184.84").positions, take().positions, atol=1e-3)
    assert "neither" not in refusal(path, unit="furlong")
    assert "expected mm, cm, m, in" in refusal(path, unit="furlong")
    assert "would make it a face" in refusal(path, unit="mm")


def body_beside(scale: float = 1.0) -> np.ndarray:
    """The face, and ten markers of a body that stand 180 mm apart below it."""
    below = np.array([[0.0, -250 - 180 * i, 90 * (i % 2)] for i in range(10)])
    return np.tile(np.concatenate([FACE, below]) * scale, (4, 1, 1))


LABELS = [f"M{i}" for i in range(18)]


def test_a_body_beside_the_face_is_told(tmp_path):
    path = custom_c3d(tmp_path / "take.c3d", LABELS, body_beside(), units=("mm",))
    read = read_marker_file(path, whole=True)
    assert read.markers.labels == tuple(LABELS)
    assert read.warnings == ()
    read = read_marker_file(path)
    assert read.markers.labels == tuple(LABELS[:8])
    assert "8 markers stand together as a face's do and are read, 10 others left out (M8, M9" in read.warnings[0]


def test_a_prop_and_a_ghost_beside_the_face(tmp_path):
    """A wand two metres off in every frame is left out; a marker that strays in one frame stays."""
    points = np.concatenate([np.tile(FACE, (9, 1, 1)), np.full((9, 1, 3), 2000.0)], axis=1)
    points[4, 3] += 3000
    points[::2, 5] = 0
    read = read_marker_file(custom_c3d(tmp_path / "take.c3d", [*NAMES, "Wand"], points, units=("mm",)))
    assert read.markers.labels == NAMES
    assert "1 other left out (Wand)" in read.warnings[0]


def test_a_dense_body_is_parted_from_the_face():
    """A body whose markers stand 70 mm apart up to the chin: a shorter link parts it."""
    below = np.array([[0.0, -130 - 70 * i, 20] for i in range(20)])
    face = np.concatenate([FACE, FACE + np.array([8, -9, 2]), FACE - np.array([9, -11, 2])])
    points = np.tile(np.concatenate([below, face]), (3, 1, 1))
    np.testing.assert_array_equal(face_cluster(points, 1.0), range(20, 44))


def test_without_a_unit_the_face_beside_a_body_decides(tmp_path):
    for scale, mm in ((1.0, 1.0), (1e-3, 1000.0)):
        read = read_marker_file(custom_c3d(tmp_path / "take.c3d", LABELS, body_beside(scale), units=("",)))
        assert (read.unit_mm, read.unit_source) == (mm, "assumed")


def test_without_a_unit_most_of_the_markers_decide_under_a_helmet(tmp_path):
    """Five markers of a helmet make the cloud half a metre: no unit's face, and no unit of its own."""
    x, y = np.meshgrid(np.linspace(-60, 60, 4), np.linspace(-90, 60, 5))
    face = np.stack([x.ravel(), y.ravel(), 40 - x.ravel() ** 2 / 90], axis=1)
    above = np.array([[90.0 * x, 250, -90.0 * z] for x, z in ((-1, 0), (0, 0), (1, 0), (-1, 1), (1, 1))])
    points = np.tile(np.concatenate([face, above]) * 1e-3, (4, 1, 1))
    labels = [f"M{i}" for i in range(25)]
    read = read_marker_file(custom_c3d(tmp_path / "take.c3d", labels, points, units=("",)))
    assert (read.unit_mm, read.unit_source) == (1000, "assumed")
    assert "read as m, in which 20 markers stand together" in "".join(read.warnings)
    assert read.markers.labels == tuple(labels[:20])


def test_a_body_alone_is_no_face(tmp_path):
    path = custom_c3d(tmp_path / "take.c3d", LABELS[:10], body_beside()[:, 8:], units=("mm",))
    line = refusal(path)
    assert "no 6 of them stand together" in line
    assert "--markers" in line


def test_largest_cluster():
    np.testing.assert_array_equal(largest_cluster(body_beside(), radius=120.0), range(8))
    assert len(largest_cluster(np.full((2, 3, 3), np.nan))) == 0


def test_known_unit():
    assert [known_unit(name) for name in ("Meters", "mm ", "in", "25", "0", "deg", "")] == [
        1000,
        1,
        25.4,
        25,
        None,
        None,
        None,
    ]
