"""d1 and d2 over the surface, and the maps that they drive: one call a frame (Ma et al. 2008, eq. 1 and 3)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, Int32

from .._kernels import polymap
from ..mesh import Attachment, Mesh
from .domain import Domain
from .marker_mesh import interpolation
from .polynomial import PolynomialMap
from .texture_space import Texels

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Products of barycentric weights in a triangle's quadratic form."""


@dataclass(frozen=True)
class ParameterField:
    """Points on the base and where each lies in the coarse mesh: S, Q and R are interpolated barycentrically.

    The product of two interpolated things is a quadratic form in the weights, the same all over a triangle: six numbers
    a triangle and frame stand in for a basis at every point.
    """

    corners: Int[np.ndarray, "m 3"]
    """The coarse mesh: markers."""
    bases: Float[np.ndarray, "k 5 2"]
    """Q and R at the markers."""
    triangle: Int32[np.ndarray, " p"]
    """Of the coarse mesh, at every point."""
    weights: Float32[np.ndarray, "2 p"]
    """Barycentric, of the first two corners."""

    def forms(self, vectors: Float[np.ndarray, "k 5"]) -> Float32[np.ndarray, "m 2 6"]:
        """d1 and d2 of one frame as quadratic forms in the weights, in the order of `PAIRS`."""
        here, across = vectors[self.corners], self.bases[self.corners]
        product = np.einsum("mas,mbsd->mdab", here, across)
        product = product + np.triu(product.swapaxes(2, 3), 1)
        return np.stack([product[:, :, a, b] for a, b in PAIRS], axis=2).astype(np.float32)

    def parameters(self, vectors: Float[np.ndarray, "k 5"], whole: bool = False) -> Float32[np.ndarray, "p q"]:
        """d1 and d2 at the points, mm, under one frame's deformation vectors; `whole`: and the vectors themselves."""
        out = np.empty((len(self.triangle), 2), np.float32)
        polymap.parameter_fields(self.forms(vectors), self.triangle, self.weights, out)
        if not whole:
            return out
        shares = np.concatenate([self.weights, 1 - self.weights.sum(axis=0, keepdims=True)])
        between = np.einsum("cp,pcs->ps", shares, vectors.astype(np.float32)[self.corners[self.triangle]])
        return np.concatenate([out, between], 1)

    @cached_property
    def runs(self) -> Int32[np.ndarray, " r"]:
        """Where neighbours in the list change their triangle; the last entry is the number of points."""
        change = np.flatnonzero(np.diff(self.triangle)) + 1
        return np.concatenate([[0], change, [len(self.triangle)]]).astype(np.int32)


class DrivenMap:
    """A map and its field, laid out for evaluation: built once, then one call a frame, from any thread."""

    def __init__(self, field: ParameterField, polynomial: PolynomialMap):
        self.field, self.polynomial = field, polynomial
        quick = polynomial.biquadratic
        planes = polynomial.with_limits().transpose(2, 1, 0) if quick else np.empty((0, 0, 0))
        self._planes = np.ascontiguousarray(planes, np.float32)

    def values(self, vectors: Float[np.ndarray, "k 5"]) -> Float32[np.ndarray, "p c"]:
        """The map's values under one frame's deformation vectors, mm."""
        if not self.polynomial.biquadratic:
            parameters = self.field.parameters(vectors, self.polynomial.whole_deformation)
            return self.polynomial.evaluate(parameters)
        out = np.empty((len(self._planes), len(self.field.triangle)), np.float32)
        forms = self.field.forms(vectors)
        polymap.evaluate_runs(forms, self.field.runs, self.field.triangle, self.field.weights, self._planes, out)
        return out.T


@dataclass(frozen=True)
class DetailMap:
    """A map on its texels: displacements in mm, or albedo."""

    texels: Texels
    field: ParameterField
    polynomial: PolynomialMap
    error: Float[np.ndarray, " p"]
    """Rms distance of the training data from the map at every texel, in its unit; NaN where no frame showed it."""
    unreliable: Bool[np.ndarray, " p"]
    """Nostrils, rims, lids, lips: data that no polynomial follows."""

    @cached_property
    def driven(self) -> DrivenMap:
        """The map laid out for evaluation."""
        return DrivenMap(self.field, self.polynomial)


def within_training(
    field: ParameterField, polynomial: PolynomialMap, vectors: Sequence[Float[np.ndarray, "k 5"]]
) -> PolynomialMap:
    """The map held to the values that it has in the frames of training, given by their deformation vectors."""
    driven = DrivenMap(field, replace(polynomial, limits=None))
    least = greatest = driven.values(vectors[0])
    for frame in vectors[1:]:
        values = driven.values(frame)
        least, greatest = np.minimum(least, values), np.maximum(greatest, values)
    return replace(polynomial, limits=np.ascontiguousarray(np.stack([least, greatest], 1)))


def parameter_field(domain: Domain, mesh: Mesh, attachment: Attachment, points: Attachment) -> ParameterField:
    """The field at `points` of the base `mesh`; `attachment` places the markers on it."""
    found = interpolation(domain.coarse, mesh, attachment, points)
    weights = np.ascontiguousarray(found.weights[:, :2].T, np.float32)
    return ParameterField(domain.coarse.triangles, domain.bases, found.triangle.astype(np.int32), weights)
