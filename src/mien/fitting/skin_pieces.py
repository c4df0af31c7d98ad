"""What of a scan is skin: lids must not be drawn onto the eyeballs that a scan shows between them."""

import numpy as np
from jaxtyping import Int

from ..mesh import Mesh, closest_point, connected_parts, submesh

SKIN_SHARE = 0.75
"""A piece counts as skin if more of its vertices than this are nearest to skin: an eyeball, which lids frame, has 0.3
to 0.6, a patch of skin about 1."""


def skin_pieces(scan: Mesh, head: Mesh, skin: Int[np.ndarray, " f"]) -> Mesh:
    """The scan without pieces that are eyes, teeth or tongue. Not in the paper.

    An eyeball is as near to a raised lid's vertices as the lid itself, and faces the same way: closest points would
    hold the lid where it was. The largest piece stays, whatever it is; eyes that hang together with the lids stay, too.

    Args:
        scan: in the space of `head`, mm.
        head: a head where the scan's is, eyes and all, in any expression: eyes keep their place.
        skin: its triangles of skin in the open.
    """
    pieces = connected_parts(scan.faces, len(scan.vertices))
    judged = np.flatnonzero(pieces != np.bincount(pieces).argmax())
    if not len(judged):
        return scan
    nearest = closest_point(head, scan.vertices[judged]).faces
    off_skin = np.bincount(pieces[judged], ~np.isin(nearest, skin), minlength=len(scan.vertices))
    stays = off_skin[pieces] <= (1 - SKIN_SHARE) * np.bincount(pieces)[pieces]
    return submesh(scan, stays[scan.faces[:, 0]])[0]
