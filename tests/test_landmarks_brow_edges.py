import numpy as np
import pytest

from mien.faces.bundled import load_face
from mien.landmarks.brow_edges import BROW_EDGES, BrowConfig, best_path, brow_edges
from mien.landmarks.detector import bundled_landmarks
from mien.mesh import Mesh, loop_subdivide

SKIN, HAIR = np.array([0.8, 0.6, 0.5]), np.array([0.3, 0.2, 0.15])
SMALL = BrowConfig(pixels=320)


@pytest.fixture(scope="module")
def skin() -> tuple[Mesh, np.ndarray]:
    """The average face's skin without colours, fine enough to paint on, and the landmarks on it."""
    mesh = load_face().rig.neutral
    points = bundled_landmarks().attachment.points(mesh)
    near = mesh.vertices[mesh.faces][:, :, 2].min(axis=1) > 50
    part = Mesh(mesh.vertices, mesh.faces[near])
    return loop_subdivide(part, 2)[0], points


def heights(points: np.ndarray, line, x: np.ndarray) -> np.ndarray:
    """y of a brow's landmarks at `x`; NaN on the other side of the face."""
    edge = points[list(line)]
    edge = edge[np.argsort(edge[:, 0])]
    return np.where(x * edge[0, 0] > 0, np.interp(x, edge[:, 0], edge[:, 1]), np.nan)


def painted(mesh: Mesh, points: np.ndarray, above: float) -> Mesh:
    """Brows 8 mm wide whose upper edges run `above` mm over the landmarks'."""
    x, y, _ = mesh.vertices.T
    dark = np.zeros(len(x), bool)
    for line in BROW_EDGES:
        upper = heights(points, line, x) + above
        within = np.abs(np.abs(x) - 36) < 28
        dark |= within & (y < upper) & (y > upper - 8)
    return Mesh(mesh.vertices, mesh.faces, colors=np.where(dark[:, None], HAIR, SKIN))


@pytest.mark.parametrize("above", [-3.0, 0.0, 3.0])
def test_edges_are_found_where_brows_are_painted(skin, above):
    mesh, points = skin
    found = brow_edges(painted(mesh, points, above), None, points, SMALL)
    for line, edge in zip(BROW_EDGES, found, strict=True):
        middle = edge[len(edge) // 4 : -len(edge) // 4]
        np.testing.assert_allclose(middle[:, 1] - heights(points, line, middle[:, 0]), above, atol=1.0)
        np.testing.assert_allclose(edge[[0, -1], 0], points[[line[0], line[-1]], 0], atol=3.5)


def test_no_colours_no_contrast_or_no_landmarks_no_edges(skin):
    mesh, points = skin
    fair = Mesh(mesh.vertices, mesh.faces, colors=np.tile(SKIN, (len(mesh.vertices), 1)))
    unseen = points.copy()
    unseen[BROW_EDGES[0][2]] = np.nan
    for surface, landmarks in ((mesh, points), (fair, points), (painted(mesh, points, 0.0), unseen)):
        assert np.isnan(brow_edges(surface, None, landmarks, SMALL)).all()


def test_the_best_path_is_the_best_of_all():
    gain = np.random.default_rng(0).normal(size=(4, 5))

    def worth(path):
        return gain[np.arange(4), path].sum() - 0.3 * (np.diff(path) ** 2).sum()

    ways = [np.array(np.unravel_index(k, (5, 5, 5, 5))) for k in range(5**4)]
    assert worth(best_path(gain, 0.3)) == pytest.approx(max(map(worth, ways)))
