"""A small curved patch of skin with markers, whose detail is a known function of how it is deformed."""

from dataclasses import replace

import numpy as np

from mien.detail.reflectance import under_dots
from mien.detail.training import Clip, Frame, TrainingSet
from mien.mesh import Mesh, closest_point

SIDE_MM, BULGE_MM = 60.0, 12.0


def patch(n: int = 33) -> Mesh:
    """A quarter barrel of n x n vertices, open, facing +Z, with texture coordinates."""
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    x, y = (u.ravel() - 0.5) * SIDE_MM, (v.ravel() - 0.5) * SIDE_MM
    z = BULGE_MM * (1 - (2 * u.ravel() - 1) ** 2)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel(), i[1:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    uv = 0.05 + 0.9 * np.stack([u.ravel(), v.ravel()], 1)
    return Mesh(np.stack([x, y, z], 1), faces, uv=uv)


def marker_places(mesh: Mesh, side: int = 5):
    """side x side markers, a little off the grid."""
    rng = np.random.default_rng(3)
    at = np.stack(np.meshgrid(*[np.linspace(-0.42, 0.42, side) * SIDE_MM] * 2), -1).reshape(-1, 2)
    at = at + rng.uniform(-1.5, 1.5, at.shape)
    height = np.interp(at[:, 0], mesh.vertices[:33, 0], mesh.vertices[:33, 2])
    return closest_point(mesh, np.column_stack([at, height])).attachment()


def bent(points: np.ndarray, squeeze: float, shear: float) -> np.ndarray:
    """The coarse motion: squeezed along x about the middle, sheared along y."""
    out = points.copy()
    out[:, 0] *= 1 - squeeze
    out[:, 1] += shear * points[:, 0]
    return out


def training(wrinkle_mm: float = 0.4, mesh: Mesh | None = None) -> TrainingSet:
    """Two clips; wrinkles across x grow with the square of the squeeze."""
    mesh = mesh or patch()
    at = marker_places(mesh)
    clips = []
    for name, squeeze, shear in (("squeeze", 0.2, 0.0), ("shear", 0.05, 0.15)):
        steps = np.linspace(0, 1, 8)
        pairs = [(squeeze * s, shear * s) for s in steps]
        markers = np.stack([at.points(mesh.with_vertices(bent(mesh.vertices, *pair))) for pair in pairs])
        clips.append(Clip(name, markers, lambda pairs=pairs: (Frame(wrinkled(mesh, *p, wrinkle_mm)) for p in pairs)))
    return TrainingSet(mesh, at.points(mesh), tuple(f"M{i}" for i in range(len(at.faces))), tuple(clips))


def wrinkled(mesh: Mesh, squeeze: float, shear: float, wrinkle_mm: float) -> np.ndarray:
    """The true skin: coarse motion, and furrows 12 mm apart that deepen with the square of the squeeze."""
    points = bent(mesh.vertices, squeeze, shear)
    points[:, 2] += wrinkle_mm * (squeeze / 0.2) ** 2 * np.cos(2 * np.pi * mesh.vertices[:, 0] / 12.0)
    return points


def painted(whole: TrainingSet) -> TrainingSet:
    """The patch in skin colour, redder the more it is squeezed; black round each marker."""

    def frames(clip):
        for markers, frame in zip(clip.markers, clip.frames(), strict=True):
            squeeze = 1 - np.ptp(markers[:, 0]) / np.ptp(whole.markers[:, 0])
            colors = np.tile([0.6 + squeeze, 0.4, 0.3], (len(frame.vertices), 1))
            colors[under_dots(frame.vertices, markers, 2.0)] = 0
            yield replace(frame, colors=colors)

    return replace(whole, clips=tuple(replace(c, frames=lambda c=c: frames(c)) for c in whole.clips))


def write_clips(folder, clips=None, colors=False):
    """The training set as files: a folder a clip."""
    from mien.clip import Markers
    from mien.io.markers.c3d import write_c3d
    from mien.io.meshes.ply import write_ply
    from mien.pictures.color import to_srgb

    whole = painted(training()) if colors else training()
    for clip in clips or whole.clips:
        place = folder / clip.name
        place.mkdir(parents=True)
        write_c3d(place / "markers.c3d", Markers(clip.markers, whole.labels, 30.0))
        for i, frame in enumerate(clip.frames()):
            mesh = whole.mesh.with_vertices(frame.vertices)
            if frame.colors is not None:
                mesh = replace(mesh, colors=to_srgb(frame.colors))
            write_ply(place / f"frame_{i:06d}.ply", mesh)
    return whole
