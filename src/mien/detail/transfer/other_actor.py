"""Wrinkles carried to another actor from one neutral scan of theirs (past the paper, whose future work it is)."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from scipy.interpolate import RBFInterpolator

from ...errors import BadInput
from ...mesh import Attachment, Mesh, closest_point
from ...pictures.color import to_linear
from ..base_mesh import base_mesh
from ..domain import Domain, marker_strains
from ..fields import DetailMap, parameter_field
from ..fit import DetailConfig, DetailModel
from ..sampling import Sampler, interpolated, sampler
from ..synthesize import at_vertices
from ..texture_space import sample, texture_gradients, with_gutter
from ..thin_shell import thin_shell
from ..training import Aligned, Clip, HeadMarkers, TrainingSet

SMOOTHING = 1e-6
"""Of the warp between the two texture spaces, in squared texture units: markers are glued by hand."""


@dataclass(frozen=True)
class OtherActor:
    """Whom the wrinkles go to."""

    neutral: Mesh
    """Scan of the neutral face with its detail; face space, mm."""
    markers: Float[np.ndarray, "k 3"]
    """Where the model's markers, in its order, sit on this face, face space, mm."""


def carried_to(model: DetailModel, actor: OtherActor, config: DetailConfig = DetailConfig()) -> DetailModel:
    """The model on another face: what changes comes from the trained person, what is there at rest is the actor's own.

    Texture spaces are laid onto each other by a thin-plate spline through the markers; Q and R stay with the markers.

    Raises:
        BadInput: another number of markers, or a scan without outer skin.
    """
    if actor.markers.shape != model.reference.shape:
        raise BadInput(
            f"detail transfer: {len(actor.markers)} markers on the other face; "
            f"give the places of the model's {len(model.reference)}"
        )
    base = base_mesh(actor.neutral, config.base)
    attachment = closest_point(base.mesh, actor.markers).attachment()
    shell = thin_shell(base.mesh, attachment, model.shell.config)
    gradients, old = texture_gradients(base.mesh), model.domain.strains
    strains = marker_strains(base.mesh, attachment, actor.markers, model.domain.coarse, gradients, old.config)
    coarse = replace(model.domain.coarse, nearest=_nearest(base.mesh, actor.markers))
    domain = replace(model.domain, strains=strains, coarse=coarse)
    still = Clip("neutral", actor.markers[None], lambda: iter(()))
    scan = TrainingSet(actor.neutral, actor.markers, model.labels, (still,))
    rest = Aligned(actor.markers, actor.neutral.vertices, None)
    warp = _warp(model, base.mesh, attachment)
    at = sampler(scan, base, shell, model.medium.texels.size, config.farthest_mm)
    own = at.displacement(rest)
    medium = _carried(model.medium, at, attachment, domain, warp, own)
    fine = None
    if model.fine is not None:
        closer = sampler(scan, base, shell, model.fine.texels.size, config.farthest_mm)
        uv = _uv(base.mesh, closer.texels.attachment)
        left = closer.displacement(rest)[:, 2] - sample(with_gutter(medium.texels.image(own)), uv)[:, 2]
        fine = _carried(model.fine, closer, attachment, domain, warp, left[:, None])
    reflectance = None
    if model.reflectance is not None and actor.neutral.colors is not None:
        skin = interpolated(to_linear(actor.neutral.colors), at.on_training, actor.neutral.faces)
        reflectance = _carried(model.reflectance, at, attachment, domain, warp, skin)
    head = HeadMarkers(actor.markers, model.head.steadiness)
    return replace(
        model, base=base.mesh, head=head, attachment=attachment, shell=shell, domain=domain, medium=medium, fine=fine,
        reflectance=reflectance,
    )  # fmt: skip


def _nearest(mesh: Mesh, markers: Float[np.ndarray, "k 3"]) -> np.ndarray:
    return np.linalg.norm(mesh.vertices[:, None] - markers, axis=2).argmin(axis=1)


def _uv(mesh: Mesh, points: Attachment) -> Float[np.ndarray, "p 2"]:
    assert mesh.uv is not None
    return interpolated(mesh.uv, points, mesh.faces)


def _warp(model: DetailModel, mesh: Mesh, attachment: Attachment) -> RBFInterpolator:
    """From the actor's texture space to the trained person's."""
    here, there = _uv(mesh, attachment), _uv(model.base, model.attachment)
    return RBFInterpolator(here, there, kernel="thin_plate_spline", smoothing=SMOOTHING)


def _carried(
    detail: DetailMap, at: Sampler, attachment: Attachment, domain: Domain, warp: RBFInterpolator,
    own: Float[np.ndarray, "p c"],
) -> DetailMap:  # fmt: skip
    """The trained coefficients at the actor's texels, with the actor's own constant term."""
    mesh, grid = at.shell.mesh, at.texels
    uv = warp(_uv(mesh, grid.attachment))
    driven = at_vertices(detail, parameter_field(domain, mesh, attachment, grid.attachment), uv)
    coefficients, limits = driven.polynomial.coefficients, driven.polynomial.limits
    own_rest = np.nan_to_num(own).astype(np.float32)
    if limits is not None:
        reach = limits - coefficients[:, -1:]
        limits = own_rest[:, None] + np.stack([np.minimum(reach[:, 0], 0), np.maximum(reach[:, 1], 0)], 1)
    coefficients[:, -1] = own_rest
    unreliable = sample(with_gutter(detail.texels.image(detail.unreliable.astype(float))), uv) > 0.5
    unreliable |= ~np.isfinite(own).all(axis=1)
    count = len(grid.pixels)
    polynomial = replace(driven.polynomial, coefficients=coefficients, limits=limits)
    return DetailMap(grid, driven.field, polynomial, np.zeros(count), unreliable)
