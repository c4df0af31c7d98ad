"""Masks that keep an expression to its part of the face, for vertices and for texels (Casas et al. 2016, sec. 5.2)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, UInt8

from ...faces.bundled import BundledFace
from ...mesh import Mesh, SurfaceImage
from ...one_line import count, one_line
from ...rig import Rig
from ...solve import box_least_squares
from ..cylinder_map import filled

REGIONS = ("upper", "eyes", "lower")
BORDER_MM = (-30.0, -6.0)
"""Heights in the bundled face between which the lower face goes over into the upper one: under the lower lids."""
EYES_MM = (20.0, 34.0)
"""Distances from an eyeball's centre over which its region ends."""
BROWS_MM = (10.0, 22.0)
"""Heights between which the eyes go over into the brows."""
OF_WORDS: dict[tuple[str, ...], tuple[str, ...]] = {
    ("cheeksquint", "nosesneer"): ("eyes", "lower"),
    ("eye", "blink", "wink", "squint"): ("eyes",),
    ("brow",): ("upper", "eyes"),
    ("jaw", "mouth", "kiss", "lip", "cheek", "tongue", "chin"): ("lower",),
}
"""Words of a name that say where an expression is: a blink whose cheeks rise must not lift the corners of a smile."""
FAINT = 0.25
"""Motion below this share of the largest does not say where an expression is."""
ENOUGH = 0.1
"""A region is an expression's if it holds this share of the motion's energy."""


@dataclass(frozen=True)
class TexturedRig:
    """A rig whose texture changes with its shapes: f and T = b0 + sum_k w_k m_k (b_k - b0), eq. 3."""

    rig: Rig
    """Deltas are masked; its texture is the neutral's."""
    textures: UInt8[np.ndarray, "captures h w 3"]
    """Of each capture, in the rig's uv; not masked."""
    captures: tuple[str, ...]
    """Their names."""
    regions: tuple[tuple[str, ...], ...]
    """Which of `REGIONS` each capture moves."""
    mask_textures: dict[str, Float[np.ndarray, "h w"]]
    """Of each region, 0..1; they add up to 1."""
    mixes: Float[np.ndarray, "captures shapes"]
    """Weights of the rig's shapes that make each capture: a target of its own, or a mix of ARKit's."""

    def __repr__(self) -> str:
        return one_line(self, self.rig, count(len(self.captures), "captured textures"))

    def mask(self, capture: int) -> Float[np.ndarray, "h w"]:
        """The mask texture of one capture: its regions' together."""
        return np.sum([self.mask_textures[name] for name in self.regions[capture]], axis=0)

    def texture(self, shares: Float[np.ndarray, " captures"]) -> UInt8[np.ndarray, "h w 3"]:
        """The texture in which the captures have these shares (`texture_weights`)."""
        base = self.rig.texture
        assert base is not None
        total = base.astype(np.float32)
        for k in np.flatnonzero(np.abs(shares) > 1e-3):
            difference = self.textures[k].astype(np.float32) - base
            total += np.float32(shares[k]) * self.mask(int(k)).astype(np.float32)[..., None] * difference
        return np.clip(total + 0.5, 0, 255).astype(np.uint8)


def region_masks(face: BundledFace) -> dict[str, Float[np.ndarray, " n"]]:
    """Vertex masks (n,) of `REGIONS` on the bundled topology; they add up to 1 everywhere."""
    height = face.rig.neutral.vertices[:, 1]
    above = _smooth_step(height, *BORDER_MM)
    centres = [face.eyeball(face.rig.neutral.vertices, side)[0] for side in ("left", "right")]
    away = np.min([np.linalg.norm(face.rig.neutral.vertices - centre, axis=1) for centre in centres], axis=0)
    eyes = (1 - _smooth_step(away, *EYES_MM)) * (1 - _smooth_step(height, *BROWS_MM))
    for side in ("left_eye", "right_eye"):
        eyes[face.parts[side]] = 1.0
    return {"upper": (1 - eyes) * above, "eyes": eyes, "lower": (1 - eyes) * (1 - above)}


def _smooth_step(values: Float[np.ndarray, " n"], low: float, high: float) -> Float[np.ndarray, " n"]:
    t = np.clip((values - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def regions_of(
    name: str,
    delta: Float[np.ndarray, "n 3"],
    masks: dict[str, Float[np.ndarray, " n"]],
    areas: Float[np.ndarray, " n"],
) -> tuple[str, ...]:
    """The regions that an expression is for: by a word of its name, else by their share of its motion's energy."""
    for words, regions in OF_WORDS.items():
        if any(word in name.lower() for word in words):
            return regions
    length = np.linalg.norm(delta, axis=1)
    energy = areas * np.maximum(length - FAINT * length.max(), 0) ** 2
    shares = {name: float((mask * energy).sum() / max(energy.sum(), 1e-12)) for name, mask in masks.items()}
    found = tuple(name for name in REGIONS if shares[name] >= ENOUGH)
    return found or (max(shares, key=lambda name: shares[name]),)


def mask_textures(mesh: Mesh, masks: dict[str, Float[np.ndarray, " n"]], size: int) -> dict[str, np.ndarray]:
    """The vertex masks drawn into the mesh's uv, gutters filled."""
    assert mesh.uv is not None
    corners = mesh.faces if mesh.uv_faces is None else mesh.uv_faces
    places = np.stack([mesh.uv[:, 0] * size - 0.5, (1 - mesh.uv[:, 1]) * size - 0.5], 1)
    image = SurfaceImage(places, corners, (size, size))
    on, stacked = image.mask, np.stack(list(masks.values()), 1)
    drawn = np.full((size, size, stacked.shape[1]), np.nan)
    drawn[on] = np.einsum("tc,tck->tk", image.barycentric[on], stacked[mesh.faces[image.faces[on]]])
    whole = filled(drawn)
    return {name: whole[..., i] for i, name in enumerate(masks)}


def masked(
    delta: Float[np.ndarray, "n 3"], regions: Sequence[str], masks: dict[str, Float[np.ndarray, " n"]]
) -> Float[np.ndarray, "n 3"]:
    """m_k (b_k - b0): what of a displacement lies in its regions."""
    return delta * np.sum([masks[name] for name in regions], axis=0)[:, None]


DAMPING = 0.02
"""Weight of no texture beside the weights that captures are to make."""


def texture_weights(
    weights: Float[np.ndarray, "frames shapes"], mixes: Float[np.ndarray, "captures shapes"]
) -> Float[np.ndarray, "frames captures"]:
    """How much of each capture's texture goes with weights of the shapes, 0..1.

    Shares c that make the weights as mixes of captures, min |c @ mixes - w|^2 + damping |c|^2: half a smile has half of
    its texture, and so has a smile that only the left side makes.
    """
    if not len(mixes):
        return np.zeros((len(weights), 0))
    return np.asarray(box_least_squares(share_gram(mixes), weights @ mixes.T, 0.0, 1.0).values)


def share_gram(mixes: Float[np.ndarray, "captures shapes"]) -> Float[np.ndarray, "captures captures"]:
    """The matrix of `texture_weights`: its shares are the least of c' gram c / 2 - c' mixes w with c in 0..1."""
    return mixes @ mixes.T + DAMPING * np.eye(len(mixes))
