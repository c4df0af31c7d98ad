"""Nonrigid registration: a template is deformed onto a surface (Huang 2011, sec. 6.1, eq. 7).

What is ours, where the paper is silent: differential coordinates turn with their neighbourhoods; all sums are
integrals over the surface, so that weights mean the same on any mesh; closest points may slide along the target; a
small membrane term keeps triangles from drifting; and a decimated template takes the first, stiff rounds.
"""

from dataclasses import dataclass, field, replace

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float, Int

from ..mesh import Attachment, ClosestPoint, Mesh, vertex_normals
from .coarse import CoarseTemplate
from .correspond import Correspondences, Rejection, Surface
from .residuals import (
    PlaneTerm,
    PointTerm,
    Stencil,
    laplacian_term,
    marker_term,
    membrane_term,
    plane_term,
    point_term,
)
from .shape import local_rotations, make_stencil, turned_edges
from .sides import same_side
from .solver import FACTOR_UP_TO, solve_vertices


@dataclass(frozen=True)
class NonrigidConfig:
    """Weights of eq. 7 and how they change from round to round. Millimetres throughout."""

    markers: float = 10000.0
    """w1, of each marker; a marker's own weight multiplies it."""
    laplacian: float = 1.0
    """w2: how much the surface resists bending."""
    closest: tuple[float, ...] = (0.1, 0.5, 2.0)
    """w3, one round of closest points after the other, on the full template."""
    coarse: tuple[float, ...] = (3e-4, 1e-3, 3e-3, 1e-2, 3e-2)
    """w3 of the rounds before, on a decimated template: stiff, for a template that starts far; () switches them off."""
    rounds: int = 1
    """Closest-point searches at each of `closest`."""
    coarse_rounds: int = 3
    """... and at each of `coarse`."""
    coarse_vertices: int = 3000
    """Size of the decimated template; a template of up to twice as many is not decimated."""
    membrane: float = 0.02
    """How much the surface resists stretching, beside `laplacian`; 0 switches it off."""
    spacing: float = 1.0
    """Distance between vertices, mm, at which the weights mean what they do in the paper (80,000 on a head)."""
    plane: float = 0.9
    """Share of the closest-point term measured across the surface, so that vertices may slide; 0: the paper's."""
    rotations: bool = True
    """Turn differential coordinates with their neighbourhoods; False: the paper's, where hardly anything turns."""
    rejection: Rejection = field(default_factory=lambda: Rejection(max_distance=5.0))
    """Which closest points count in the rounds of `closest`."""
    coarse_rejection: Rejection = field(default_factory=lambda: Rejection(max_distance=20.0))
    """... and of `coarse`."""


@dataclass(frozen=True)
class Anchors:
    """Points of the template that have a place to go: markers or landmarks."""

    attachment: Attachment
    """On the template."""
    points: Float[np.ndarray, "k 3"]
    """Where they belong, mm, in the target's frame."""
    weights: Float[np.ndarray, " k"]
    """Multiply w1; 0 leaves one out."""


@dataclass(frozen=True)
class NonrigidResult:
    """A template on a target."""

    vertices: Float[np.ndarray, "n 3"]
    distances: Float[np.ndarray, " n"]
    """From each vertex to the target, mm."""
    accepted: Bool[np.ndarray, " n"]
    """Whether the closest point was believed at the end."""
    rounds: int
    converged: bool
    """Whether the last round moved the vertices by less than 0.1 mm rms."""
    costs: dict[str, float]
    """Value of each term of eq. 7 at the end, weights included."""


class Template:
    """A template made ready: its stencil, and a coarse stand-in for stiff rounds. Build once, register often.

    Raises:
        BadInput: a template to be decimated that has edges of more than two triangles or mixed winding.
    """

    def __init__(self, mesh: Mesh, coarse_vertices: int = NonrigidConfig.coarse_vertices):
        self.mesh = mesh
        self.stencil = make_stencil(mesh.vertices, mesh.faces)
        self._coarse = CoarseTemplate(mesh, coarse_vertices) if 0 < 2 * coarse_vertices < len(mesh.vertices) else None
        self.prolongation: sp.csr_matrix | None = None
        """(n, k): fine displacements from those of a coarse mesh, for the solver; None where it needs no such help."""
        if len(mesh.vertices) > FACTOR_UP_TO:
            coarse = self._coarse or CoarseTemplate(mesh, NonrigidConfig.coarse_vertices)
            self.prolongation = coarse.prolongation

    def register(
        self,
        target: Surface | ClosestPoint | Mesh,
        anchors: Anchors | None = None,
        config: NonrigidConfig | None = None,
        start: Float[np.ndarray, "n 3"] | None = None,
        trust: Float[np.ndarray, " n"] | None = None,
        sides: Int[np.ndarray, " n"] | None = None,
    ) -> NonrigidResult:
        """Deform the template onto `target`, which is rigidly aligned with it already.

        Args:
            anchors: markers or landmarks; first of all the template is deformed to meet them alone.
            start: where the vertices are now, if not at rest.
            trust: multiplies the closest-point term of each vertex: 0 where the target has no such surface.
            sides: which of two lips or lids a vertex is of (see `sides.same_side`); the two never match each other.
        """
        config = config or NonrigidConfig()
        surface = target if isinstance(target, Surface) else Surface(target)
        x = self.mesh.vertices if start is None else start
        trust = np.ones(len(x)) if trust is None else trust
        markers = _anchored(self.mesh, anchors, config)
        body = _Body(self.mesh, self.stencil, markers, trust, config, self.prolongation, sides)
        coarse_body = _coarse_body(self._coarse, body, anchors, config) if self._coarse else body
        y = self._coarse.down(x) if self._coarse else x
        stiff = [*np.zeros(3 if anchors else 0), *np.repeat(config.coarse, config.coarse_rounds)]
        for w3 in stiff:
            y = coarse_body.round(y, surface, float(w3), config.coarse_rejection)
        if stiff:
            x = self._coarse.up(y) if self._coarse else y
        soft, before = np.repeat(config.closest, config.rounds), x
        for w3 in soft:
            before, x = x, body.round(x, surface, float(w3), config.rejection)
        moved = float(np.sqrt(((x - before) ** 2).sum(axis=1).mean()))
        pairs = body.pairs(x, surface, config.rejection)
        costs = body.costs(x, pairs, float(config.closest[-1]) if config.closest else 0.0)
        return NonrigidResult(x, pairs.distances, pairs.accepted, len(stiff) + len(soft), moved < 0.1, costs)


def register_surface(
    template: Mesh,
    target: Surface | ClosestPoint | Mesh,
    anchors: Anchors | None = None,
    config: NonrigidConfig | None = None,
    start: Float[np.ndarray, "n 3"] | None = None,
    trust: Float[np.ndarray, " n"] | None = None,
) -> NonrigidResult:
    """One-shot `Template(template).register(...)`."""
    size = NonrigidConfig.coarse_vertices if config is None else config.coarse_vertices
    return Template(template, size).register(target, anchors, config, start, trust)


def _anchored(mesh: Mesh, anchors: Anchors | None, config: NonrigidConfig) -> PointTerm | None:
    if anchors is None:
        return None
    return marker_term(anchors.attachment.matrix(mesh), anchors.points, config.markers * anchors.weights)


def _coarse_body(coarse: CoarseTemplate, fine: "_Body", anchors: Anchors | None, config: NonrigidConfig) -> "_Body":
    moved = None if anchors is None else replace(anchors, attachment=coarse.attachment(anchors.attachment))
    markers = _anchored(coarse.mesh, moved, config)
    return _Body(coarse.mesh, coarse.stencil, markers, coarse.averaged(fine.trust), config)


@dataclass(frozen=True)
class _Body:
    """Everything about the template that a round needs."""

    mesh: Mesh
    stencil: Stencil
    markers: PointTerm | None
    trust: np.ndarray
    config: NonrigidConfig
    prolongation: sp.csr_matrix | None = None
    sides: np.ndarray | None = None

    def round(self, x: np.ndarray, surface: Surface, w3: float, rejection: Rejection) -> np.ndarray:
        """Search closest points, turn the differential coordinates, solve."""
        points, planes = self.shape_terms(x), None
        if w3:
            used = np.flatnonzero(self.trust > 0)
            found = surface.correspond(x[used], vertex_normals(x, self.mesh.faces)[used], rejection)
            if self.sides is not None:
                allowed = same_side(x[used], self.sides[used], found.points)
                found = replace(found, accepted=found.accepted & allowed)
            more, planes = self.surface_terms(found.among(len(x), used), w3)
            points += more
        return solve_vertices(points, planes, x, prolongation=self.prolongation).vertices

    def pairs(self, x: np.ndarray, surface: Surface, rejection: Rejection) -> Correspondences:
        return surface.correspond(x, vertex_normals(x, self.mesh.faces), rejection)

    def shape_terms(self, x: np.ndarray) -> list[PointTerm]:
        config, rest = self.config, self.mesh.vertices
        rotations = local_rotations(self.stencil, rest, x) if config.rotations else None
        edges = turned_edges(self.stencil, rest, rotations)
        terms = [laplacian_term(self.stencil, edges, config.laplacian, config.spacing)]
        if config.membrane:
            terms.append(membrane_term(self.stencil, edges, config.laplacian * config.membrane))
        return terms + ([self.markers] if self.markers else [])

    def surface_terms(self, pairs: Correspondences, w3: float) -> tuple[list[PointTerm], PlaneTerm]:
        config = self.config
        weights = w3 * self.trust * pairs.accepted * self.stencil.mass / config.spacing**2
        return (
            [point_term(pairs.points, (1 - config.plane) * weights)],
            plane_term(pairs.points, pairs.normals, config.plane * weights),
        )

    def costs(self, x: np.ndarray, pairs: Correspondences, w3: float) -> dict[str, float]:
        names = ["laplacian", *(["membrane"] if self.config.membrane else []), *(["markers"] if self.markers else [])]
        found = {name: term.cost(x) for name, term in zip(names, self.shape_terms(x), strict=True)}
        points, planes = self.surface_terms(pairs, w3)
        return found | {"closest": points[0].cost(x) + planes.cost(x)}
