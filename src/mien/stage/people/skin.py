"""A performer's skin at 80,000 to 200,000 vertices: smooth subdivision, wrinkles that buckle, pores that stretch."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float, Int

from ...errors import BadInput
from ...landmarks.detector import bundled_landmarks
from ...mesh import Mesh, adjacency, loop_refinement, submesh, vertex_normals
from .albedo import albedo, blood_moved
from .performer import Performer
from .strain import StrainGauge, strain_gauge
from .wrinkles import FaceMap, Pattern, buckling, patterns


@dataclass(frozen=True)
class SkinConfig:
    """How fine the skin is."""

    levels: int = 3
    """Rounds of subdivision of the skin; each has four times the triangles."""
    whole_head: bool = False
    """Keep the back of the head and the neck too."""
    wrinkles: float = 1.0
    """Multiplies every wrinkle's depth. 0: none."""
    pores: float = 0.035
    """Rms height of the pores on nose and cheeks, mm. 0: none."""
    eyes_and_teeth: bool = True
    """Eyeballs, teeth and tongue too, as coarse as they are."""


@dataclass(frozen=True)
class Skin:
    """A performer seen closely. Acts as a `Performer` does wherever vertices are asked for."""

    performer: Performer
    neutral: Mesh
    """At rest with its detail; colours on the vertices; face space, mm."""
    smooth: sp.csr_matrix
    """(n, coarse): Loop's subdivision, the surface without wrinkles and pores."""
    straight: sp.csr_matrix
    """(n, coarse): which point of the bundled topology each vertex is, as weights on its vertices."""
    bundled: Int[np.ndarray, " coarse"]
    """The vertex that each vertex of the bundled topology has become; -1 where the skin was cut off."""
    patterns: tuple[Pattern, ...]
    gauges: tuple[StrainGauge, ...]
    """One a pattern."""
    pores: Float[np.ndarray, " n"]
    """Height at rest, mm."""
    stretch: tuple[StrainGauge, StrainGauge]
    """Two crossed gauges for the area's change."""

    @property
    def names(self) -> tuple[str, ...]:
        """The ARKit names, one a weight."""
        return self.performer.names

    @property
    def skin(self) -> Bool[np.ndarray, " n"]:
        """Mask of skin: not eyeballs, teeth or tongue."""
        return (self.straight @ self.performer.skin) > 0.5

    def vertices(
        self, weights: Float[np.ndarray, "frames shapes"], rows: Int[np.ndarray, " m"] | None = None
    ) -> Float[np.ndarray, "frames m 3"]:
        """The skin, or its vertices `rows`, under each frame's weights, mm, face space. Mind the memory."""
        patch = self._whole if rows is None else self._patch(rows)
        out = np.empty((len(weights), len(patch.pores), 3))
        for i, coarse in enumerate(self.performer.stream(weights)):
            out[i] = self._refined(coarse, patch)
        return out

    def height(self, weights: Float[np.ndarray, " shapes"]) -> Float[np.ndarray, " n"]:
        """Wrinkles and pores above the smooth surface in one frame, mm."""
        return self._height(self.performer.vertices(weights[None])[0], self._whole)

    @cached_property
    def _whole(self) -> "_Patch":
        return self._patch(np.arange(len(self.neutral.vertices)))

    def _patch(self, rows: np.ndarray) -> "_Patch":
        smooth, spots = self.smooth[rows], []
        for pattern in self.patterns:
            here = np.flatnonzero(pattern.relief[rows])
            spots.append((here, smooth[here], pattern.relief[rows[here]]))
        return _Patch(smooth, self.pores[rows], spots)

    def _refined(self, coarse: np.ndarray, patch: "_Patch") -> np.ndarray:
        normals = patch.smooth @ vertex_normals(coarse, self.performer.neutral.faces)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
        return patch.smooth @ coarse + self._height(coarse, patch)[:, None] * normals

    def _height(self, coarse: np.ndarray, patch: "_Patch") -> np.ndarray:
        area = sum(gauge.compression(coarse[None])[0] for gauge in self.stretch)
        height = patch.pores * np.clip(1 + patch.smooth @ area, 0.5, 1.5)
        for pattern, gauge, (here, smooth, relief) in zip(self.patterns, self.gauges, patch.spots, strict=True):
            compression = smooth @ gauge.compression(coarse[None])[0]
            amount = pattern.permanent + (1 - pattern.permanent) * buckling(compression, pattern.threshold)
            height[here] += pattern.depth * amount * relief
        return height

    def colors(self, weights: Float[np.ndarray, " shapes"]) -> Float[np.ndarray, "n 3"]:
        """Vertex colours in one frame, sRGB: blood leaves skin that is stretched and gathers where it is squeezed."""
        coarse = self.performer.vertices(weights[None])[0]
        area = sum(gauge.compression(coarse[None])[0] for gauge in self.stretch)
        assert self.neutral.colors is not None
        return np.clip(self.neutral.colors + blood_moved(self.smooth @ area), 0, 1)

    def mesh(self, weights: Float[np.ndarray, " shapes"]) -> Mesh:
        """One frame's skin, with colours."""
        return self.neutral.with_vertices(self.vertices(weights[None])[0])


class _Patch(NamedTuple):
    """What is needed of some of the skin's vertices."""

    smooth: sp.csr_matrix
    pores: np.ndarray
    spots: list[tuple[np.ndarray, sp.csr_matrix, np.ndarray]]
    """For each pattern: where it is, the rows of `smooth` there, its relief there."""


def make_skin(performer: Performer, config: SkinConfig | None = None, seed: int = 0) -> Skin:
    """The performer's skin; wrinkles, pores and albedo are drawn by `seed`.

    Raises:
        BadInput: levels outside 0..4.
    """
    config = config or SkinConfig()
    if not 0 <= config.levels <= 4:
        raise BadInput(f"levels: expected 0 to 4 rounds of subdivision, got {config.levels}")
    rng = np.random.default_rng([seed, 7])
    smooth, straight, faces, bundled, is_skin = _subdivide(performer, config)
    points = smooth @ performer.neutral.vertices
    where = face_map(performer)
    drawn = [_scaled(p, config.wrinkles * is_skin) for p in patterns(points, where, rng)]
    gauges = [_gauge(performer, smooth, bundled, pattern) for pattern in drawn]
    pores = _pores(points, faces, where, rng) * config.pores * is_skin
    skin = Skin(
        performer=performer,
        neutral=Mesh(points, faces),
        smooth=smooth,
        straight=straight,
        bundled=bundled,
        patterns=tuple(drawn),
        gauges=tuple(gauges),
        pores=pores,
        stretch=_crossed(performer),
    )
    rest = skin.vertices(np.zeros((1, len(performer.names))))[0]
    colors = albedo(performer.neutral, smooth, straight, points, is_skin, rng)
    return replace(skin, neutral=Mesh(rest, faces, colors=colors))


def face_map(performer: Performer) -> FaceMap:
    """Landmarks of the resting face."""
    points = bundled_landmarks().attachment.points(performer.neutral)
    return FaceMap(
        eye=np.stack([performer.eyes[side].centre for side in ("Left", "Right")]),
        canthus=points[[263, 33]],
        wing=points[[278, 48]],
        mouth=points[[291, 61]],
        chin=points[199],
    )


def _subdivide(performer: Performer, config: SkinConfig):
    """Skin refined, the other parts as they are: (smooth, straight, faces, bundled, mask of skin)."""
    mesh, n = performer.neutral, len(performer.neutral.vertices)
    on_skin = performer.skin[mesh.faces].all(axis=1)
    corners = mesh.vertices[mesh.faces]
    front = (corners[..., 2].max(axis=1) > 5) & (corners[..., 1].max(axis=1) > -118)
    skin, old = submesh(mesh, np.flatnonzero(on_skin & (front | config.whole_head)))
    smooth = straight = sp.csr_matrix((np.ones(len(old)), (np.arange(len(old)), old)), shape=(len(old), n))
    faces, count = skin.faces, len(old)
    for _ in range(config.levels):
        finer = loop_refinement(faces, count)
        smooth, straight, faces = finer.matrix @ smooth, finer.between @ straight, finer.faces
        count = int(faces.max()) + 1
    bundled = np.full(n, -1)
    bundled[old] = np.arange(len(old))
    total = count
    if config.eyes_and_teeth:
        other = np.flatnonzero(~performer.skin)
        pick = sp.csr_matrix((np.ones(len(other)), (np.arange(len(other)), other)), shape=(len(other), n))
        bundled[other] = count + np.arange(len(other))
        smooth, straight = sp.vstack([smooth, pick]), sp.vstack([straight, pick])
        rest = mesh.faces[~performer.skin[mesh.faces].any(axis=1)]
        faces, total = np.concatenate([faces, bundled[rest]]), count + len(other)
    is_skin = np.arange(total) < count
    return sp.csr_matrix(smooth), sp.csr_matrix(straight), faces, bundled, is_skin


def _scaled(pattern: Pattern, by: np.ndarray) -> Pattern:
    relief = np.where(np.abs(pattern.relief) > 1e-3, pattern.relief * by, 0.0)
    return replace(pattern, relief=relief)


def _gauge(performer: Performer, smooth: sp.csr_matrix, bundled: np.ndarray, pattern: Pattern) -> StrainGauge:
    """A gauge on the performer's coarse triangles under one pattern and a little round it, across its furrows."""
    mesh, n = performer.neutral, len(performer.neutral.vertices)
    needed = np.asarray(abs(smooth[np.flatnonzero(pattern.relief)]).sum(axis=0)).ravel() > 0
    around = adjacency(mesh.faces, n)
    for _ in range(3):
        needed = needed | (around @ needed > 0)
    kept = performer.skin & (bundled >= 0)
    direction = np.zeros((n, 3))
    direction[kept] = pattern.direction[bundled[kept]]
    used = np.flatnonzero(kept[mesh.faces].all(axis=1) & needed[mesh.faces].any(axis=1))
    return strain_gauge(mesh, used, direction[mesh.faces[used]].mean(axis=1))


def _crossed(performer: Performer) -> tuple[StrainGauge, StrainGauge]:
    mesh = performer.neutral
    used = np.flatnonzero(performer.skin[mesh.faces].all(axis=1))
    x, y = (strain_gauge(mesh, used, np.tile(np.eye(3)[axis], (len(used), 1))) for axis in (0, 1))
    return x, y


def _pores(points: np.ndarray, faces: np.ndarray, where: FaceMap, rng: np.random.Generator) -> np.ndarray:
    """Pits at random vertices and a fine grain, unit rms on nose and cheeks, less elsewhere; none on the lips' edge."""
    n = len(points)
    pits = -2.2 * (rng.random(n) < 0.22) * rng.uniform(0.5, 1.5, n)
    grain = pits + 0.5 * rng.normal(size=n)
    grain -= grain.mean()
    nose = (where.wing.mean(axis=0) + where.eye.mean(axis=0)) / 2
    near = np.exp(-(((points[:, :2] - nose[:2]) / [38, 34]) ** 2).sum(axis=1))
    mouth = np.exp(-(((points[:, :2] - where.mouth.mean(axis=0)[:2]) / [26, 9]) ** 4).sum(axis=1))
    return grain / grain.std() * (0.35 + 0.65 * near) * (1 - mouth)
