"""The one shrink-wrap: the fitted face's skin onto a surface by eq. 7, everything hidden along with it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ..faces.bundled import BundledFace
from ..mesh import Mesh
from ..register.correspond import Surface
from ..register.nonrigid import Anchors, NonrigidConfig, Template
from .template_parts import TemplateParts, extrapolate_hidden, move_rigid_parts


@dataclass(frozen=True)
class WrapStage:
    """One call of the nonrigid registration: stiff stages first, soft ones after."""

    config: NonrigidConfig
    anchors: Anchors | None = None
    """On the whole face's triangles; None: the surface alone."""


def shrink_wrap(
    face: BundledFace,
    parts: TemplateParts,
    start: Mesh,
    surface: Surface,
    stages: Sequence[WrapStage],
    trust: Float[np.ndarray, " n"],
) -> Mesh:
    """Draw the skin of `start` (bundled topology) onto `surface`, both in face space, mm (Huang 2011, eq. 7).

    Skin that the surface does not show (`trust` 0) goes with the skin around it; eyes, teeth and tongue move rigidly.
    """
    template = Template(Mesh(start.vertices[parts.skin], parts.skin_triangles))
    on_skin, sides = trust[parts.skin], parts.sides[parts.skin]
    skin = template.mesh.vertices
    for stage in stages:
        anchors = stage.anchors
        if anchors is not None:
            anchors = replace(anchors, attachment=parts.attached(anchors.attachment))
        skin = template.register(surface, anchors, stage.config, skin, on_skin, sides).vertices
    vertices = start.vertices.copy()
    vertices[parts.skin] = extrapolate_hidden(template, skin, on_skin > 0, sides)
    shown = parts.trust[parts.skin] > 0
    return start.with_vertices(move_rigid_parts(face.parts, parts.skin, shown, start.vertices, vertices))
