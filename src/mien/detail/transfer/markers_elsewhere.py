"""Novel marker placement: a take whose markers sit elsewhere than in training, or are more, or fewer (sec. 5, end)."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ...clip import Markers, visible
from ...errors import BadInput
from ...mesh import ClosestPoint, closest_point
from ...register import procrustes
from ...register.align import AlignConfig, align
from ...takes.gaps import GapConfig, fill_gaps
from ...transforms import Transform
from ..drive import Drive, followed
from ..fit import DetailModel
from ..marker_mesh import marker_mesh
from ..thin_shell import thin_shell
from ..training import HeadMarkers

SHARED = 4
"""Labels in common from which the neutral is laid onto the training's; with fewer its shape is."""


@dataclass(frozen=True)
class Placement:
    """New markers on the training neutral: the training's own follow them."""

    labels: tuple[str, ...]
    head: HeadMarkers
    """The new markers at the neutral, face space."""
    model: DetailModel
    """With the new markers in place of the training's: only its shell and its coarse mesh are of use."""
    carry: Float[np.ndarray, "k j"]
    """Displacement of each training marker for unit displacements of the new ones."""
    reference: Float[np.ndarray, "k 3"]
    """The training's markers at the neutral."""

    def drive(self, markers: Markers, gaps: GapConfig = GapConfig()) -> Drive:
        """The training's markers as the new ones carry them; strains then have the training's density by themselves.

        Raises:
            BadInput: a frame that shows fewer than three markers.
        """
        positions = markers.positions
        shown = visible(positions).sum(axis=1)
        if (shown < 3).any():
            raise BadInput(f"frame {int(np.argmax(shown < 3))} shows fewer than 3 markers; cut it off")
        T_lab_face = self.head.pose(positions)
        still = fill_gaps(T_lab_face.inverse().apply(positions), markers.rate, gaps)
        seen = visible(still)
        offset = followed(self.model, still, seen) - self.head.reference
        carried = np.einsum("kj,tjd->tkd", self.carry, offset)
        return Drive(self.reference + carried, T_lab_face, 1 - seen.mean(axis=0))


def place_markers(model: DetailModel, markers: Markers, frame: int) -> Placement:
    """Lay the markers of a neutral `frame` onto the training neutral, and let the thin shell between them carry on.

    Raises:
        BadInput: no such frame, markers missing in it, or markers that do not lie on this face.
    """
    if not 0 <= frame < len(markers.positions):
        raise BadInput(f"placement: frame {frame} of {len(markers.positions)}; give the number of a neutral frame")
    here = visible(markers.positions)[frame]
    if here.sum() < SHARED:
        raise BadInput(f"placement: frame {frame} shows {int(here.sum())} markers; give a neutral frame that shows all")
    labels = tuple(np.array(markers.labels)[here])
    neutral = markers.positions[frame][here]
    return placed_at(model, labels, neutral_pose(model, labels, neutral).apply(neutral))


def placed_at(model: DetailModel, labels: tuple[str, ...], reference: Float[np.ndarray, "j 3"]) -> Placement:
    """New markers whose places at the neutral are known in face space, mm."""
    attachment = closest_point(model.base, reference).attachment()
    shell = thin_shell(model.base, attachment, model.shell.config)
    carry = model.attachment.matrix(model.base) @ shell.response
    distance = np.linalg.norm(reference[:, None] - model.reference, axis=2)
    head = HeadMarkers(reference, model.head.steadiness[distance.argmin(axis=1)])
    coarse = marker_mesh(model.base, attachment)
    domain = replace(model.domain, coarse=coarse)
    new = replace(model, labels=labels, head=head, attachment=attachment, shell=shell, domain=domain)
    return Placement(labels, head, new, carry, model.reference)


def neutral_pose(model: DetailModel, labels: tuple[str, ...], neutral: Float[np.ndarray, "j 3"]) -> Transform:
    """T_face_lab of a neutral frame: by the labels that it shares with the training, else by its shape."""
    place = {label: i for i, label in enumerate(model.labels)}
    shared = [i for i, label in enumerate(labels) if label in place]
    if len(shared) >= SHARED:
        target = model.reference[[place[labels[i]] for i in shared]]
        return procrustes(neutral[shared], target).transform
    found = align(neutral, ClosestPoint(model.base), AlignConfig(scale_range=0.0))
    if not found:
        raise BadInput("placement: the markers do not lie on the trained face in any position; is the frame neutral?")
    return found[0].T_face_head
