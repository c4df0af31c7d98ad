"""From markers to a detailed face, frame by frame (Ma et al. 2008, sec. 5)."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Float32, Int

from .._kernels._spread import pool_of_generator
from ..mesh import Attachment, Mesh, loop_subdivide
from ..mesh.subdivide import Refinement
from ..pictures.color import to_srgb
from .fields import DetailMap, DrivenMap, ParameterField, parameter_field
from .fit import DetailModel
from .texture_space import four_texels, tangent_frames, texture_gradients

OTHER_MARKERS = 0.75
"""Difference of two points' shares in markers (0: the same, 2: none in common) from which they hang on others."""
LEAST_SHARE = 1e-3
"""Of a vertex's four texels, below which none of them counts."""
AHEAD = 4
"""Frames that may be under way at once, so that memory does not grow with the take."""


@dataclass(frozen=True)
class SynthesisConfig:
    """What is made of the maps."""

    levels: int = 0
    """Rounds of subdivision of the base mesh that the maps displace; 0 is about 10,000 vertices, 2 about 160,000."""
    medium: bool = True
    """Apply the medium map; False shows the thin shell."""
    fine_vertices: bool = False
    """Add the fine map to the vertices too (a dense mesh that needs no displacement mapping)."""
    fine_map: bool = True
    """Evaluate the fine map's image, for displacement mapping."""
    colors: bool = True
    """Colours too, where the maps have them."""


@dataclass(frozen=True)
class SynthesizedFrame:
    """One frame of detail, with the head still."""

    vertices: Float32[np.ndarray, "n 3"]
    """Face space, mm."""
    fine: Float32[np.ndarray, " p"] | None
    """Height along the normal at every texel of the fine map, mm."""
    colors: Float32[np.ndarray, "n 3"] | None = None
    """Linear albedo of the vertices, 0..1."""


class Synthesizer:
    """A person's detail on a mesh of any density: built once, then one call a frame.

    Frames may be asked for from several threads: nothing is changed by a call.
    """

    def __init__(self, model: DetailModel, config: SynthesisConfig = SynthesisConfig()):
        self.model, self.config = model, config
        dense, S = loop_subdivide(model.base, config.levels)
        self.mesh: Mesh = dense
        """The dense base at rest, with texture coordinates; frames have its vertex order."""
        self._upsample = sp.csr_matrix(S, dtype=np.float32)
        along_u, along_v = texture_gradients(dense)
        self._gradients = sp.csr_matrix(along_u, dtype=np.float32), sp.csr_matrix(along_v, dtype=np.float32)
        places = vertex_attachment(dense, model, S)
        field = parameter_field(model.domain, model.base, model.attachment, places)
        assert dense.uv is not None
        self._medium = at_vertices(model.medium, field, dense.uv)
        self._fine = None
        if model.fine is not None and config.fine_vertices:
            self._fine = at_vertices(model.fine, field, dense.uv)
        self._colors = None
        if model.reflectance is not None and config.colors:
            self._colors = at_vertices(model.reflectance, field, dense.uv)
        self._response = np.ascontiguousarray(model.shell.response, np.float32)
        self._rest = model.base.vertices.astype(np.float32)

    def frame(self, markers: Float[np.ndarray, "k 3"]) -> SynthesizedFrame:
        """The six steps of sec. 5 but the last.

        Args:
            markers: aligned rigidly with the neutral (`HeadMarkers.aligned`), mm.
        """
        model, config = self.model, self.config
        vectors = model.domain.vectors(markers[None])[0]
        vertices = self.shell(markers)
        if config.medium:
            vertices = self._displaced(vertices, vectors)
        fine = None
        if model.fine is not None and config.fine_map:
            fine = model.fine.driven.values(vectors)[:, 0]
        colors = None if self._colors is None else np.clip(self._colors.values(vectors), 0, 1)
        return SynthesizedFrame(vertices, fine, colors)

    def shell(self, markers: Float[np.ndarray, "k 3"]) -> Float32[np.ndarray, "n 3"]:
        """The base motion alone on the dense mesh (step 1), mm."""
        offset = (markers - self.model.reference).astype(np.float32)
        return self._upsample @ (self._rest + self._response @ offset)

    def frames(self, markers: Float[np.ndarray, "frames k 3"], workers: int = 2) -> Iterator[SynthesizedFrame]:
        """All frames in order, `workers` of them at a time: parallel over frames, not inside one."""
        with pool_of_generator(workers) as pool:
            waiting = []
            for frame in markers:
                waiting.append(pool.submit(self.frame, frame))
                if len(waiting) >= AHEAD * workers:
                    yield waiting.pop(0).result()
            for last in waiting:
                yield last.result()

    def _displaced(self, vertices: np.ndarray, vectors: np.ndarray) -> Float32[np.ndarray, "n 3"]:
        """Steps 4 and 5: medium offsets in the base's local frames, fine heights along its normals."""
        offset = self._medium.values(vectors)
        if self._fine is not None:
            offset = offset + self._fine.values(vectors) * np.array([0, 0, 1], np.float32)
        local = tangent_frames(self._gradients, vertices)
        return vertices + np.einsum("pa,pab->pb", offset, local)


def coloured(mesh: Mesh, frame: SynthesizedFrame) -> Mesh:
    """The mesh with the frame's colours, sRGB; unchanged where it has none."""
    return mesh if frame.colors is None else replace(mesh, colors=to_srgb(frame.colors.astype(float)))


def vertex_attachment(dense: Mesh, model: DetailModel, S: sp.spmatrix) -> Attachment:
    """Where on the base each vertex of its subdivision lies: the triangle that it came from, straight along edges."""
    base = model.base
    per = len(dense.faces) // len(base.faces)
    levels = round(np.log(per) / np.log(4))
    corners = np.tile(np.eye(3), (len(base.faces), 1, 1))
    for _ in range(levels):
        corners = Refinement.corners(corners)
    faces = np.repeat(np.arange(len(base.faces)), per)
    flat, first = np.unique(dense.faces.ravel(), return_index=True)
    assert len(flat) == len(dense.vertices)
    return Attachment(np.repeat(faces, 3)[first], corners.reshape(-1, 3)[first])


def at_vertices(detail: DetailMap, field: ParameterField, uv: Float[np.ndarray, "n 2"]) -> DrivenMap:
    """A map at vertices: coefficients bilinear between texels; unreliable texels take their surroundings'.

    Coefficients mean something under their own texel's parameters alone, and those jump where the nearest marker
    changes beyond the outermost ones. A texel that hangs on other markers than the vertex is left out of its mean; a
    vertex whose texels all do takes the nearest one's parameters with its coefficients.
    """
    usable = ~detail.unreliable
    usable = usable if usable.any() else np.ones(len(usable), bool)
    texels, shares = four_texels(detail.texels, usable, uv)
    nearest = texels[np.arange(len(uv)), shares.argmax(axis=1)]
    apart = np.stack([_apart(field, detail.field, column) for column in texels.T], 1)
    shares = shares * (apart < OTHER_MARKERS)
    alone = shares.sum(axis=1) < LEAST_SHARE
    texels[alone] = nearest[alone, None]
    shares[alone] = 1.0
    shares = (shares / shares.sum(axis=1, keepdims=True)).astype(np.float32)
    known = detail.polynomial.coefficients
    read = _mean_of(known, texels, shares)
    limits = None if detail.polynomial.limits is None else _mean_of(detail.polynomial.limits, texels, shares)
    triangle = np.where(alone, detail.field.triangle[nearest], field.triangle)
    weights = np.where(alone, detail.field.weights[:, nearest], field.weights)
    polynomial = replace(detail.polynomial, coefficients=read, seen=np.ones(len(uv), bool), limits=limits)
    return DrivenMap(replace(field, triangle=triangle, weights=np.ascontiguousarray(weights)), polynomial)


def _mean_of(
    values: Float32[np.ndarray, "p m c"], texels: Int[np.ndarray, "n 4"], shares: Float32[np.ndarray, "n 4"]
) -> Float32[np.ndarray, "n m c"]:
    """Of each point's four texels, by their shares."""
    mean = np.zeros((len(texels), *values.shape[1:]), np.float32)
    for share, column in zip(shares.T, texels.T, strict=True):
        mean += share[:, None, None] * values[column]
    return mean


def _apart(field: ParameterField, of_map: ParameterField, texels: Int[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    """How much the shares of their markers differ between each vertex and a texel: 0 to 2."""
    here, there = field.corners[field.triangle], of_map.corners[of_map.triangle[texels]]
    mine, other = (np.column_stack([w.T, 1 - w.sum(axis=0)]) for w in (field.weights, of_map.weights[:, texels]))
    common = ((here[:, :, None] == there[:, None, :]) * mine[:, :, None]).sum(axis=1)
    return np.abs(other - common).sum(axis=1) + 1 - common.sum(axis=1)
