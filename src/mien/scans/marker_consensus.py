"""What registered scans agree on about the markers: where on the template they are, and how high above it."""

import numpy as np
from jaxtyping import Bool, Float

from ..mesh import Attachment, Mesh
from ..takes.marker_model import normals_at
from .scan_template import ScanTemplate


def consensus_attachment(
    template: ScanTemplate,
    skin: Float[np.ndarray, "scans n 3"],
    points: list[np.ndarray],
    covered: Bool[np.ndarray, "scans markers"],
) -> Attachment:
    """Where on the template the markers are, as the scans agree on it, now that they correspond.

    Each scan's skin points (markers, 3) are brought to the neutral scan by the correspondences; the median of all is
    nearer the truth than the neutral scan's own, since actors miss each expression in another way.
    """
    rest = Mesh(skin[0], template.skin.faces)
    found = [template.attachment_of(x, p).points(rest) for x, p in zip(skin, points, strict=True)]
    brought = np.where(covered[..., None], np.stack(found), np.nan)
    brought[0] = found[0]
    return template.attachment_of(rest.vertices, np.nanmedian(brought, axis=0))


def consensus_standoff(
    template: ScanTemplate,
    skin: Float[np.ndarray, "scans n 3"],
    attachment: Attachment,
    markers: Float[np.ndarray, "scans markers 3"],
    covered: Bool[np.ndarray, "scans markers"],
    otherwise: Float[np.ndarray, " markers"],
) -> Float[np.ndarray, " markers"]:
    """Mean height of each marker above its skin point over the scans, mm; `otherwise` where no scan shows one."""
    D, faces = attachment.matrix(template.skin), template.skin.faces
    total = np.zeros(len(otherwise))
    for x, there, held in zip(skin, markers, covered, strict=True):
        total += held * np.einsum("md,md->m", there - D @ x, normals_at(D, x, faces))
    count = covered.sum(axis=0)
    return np.where(count > 0, np.maximum(total / np.maximum(count, 1), 0.0), otherwise)
