"""The bundled face: one head, 52 expressions and an identity space, ready without any file of the user's."""

from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int

from ..mesh import Mesh
from ..one_line import one_line
from ..rig import Rig
from .lids import fit_blink, opening

WIDEST_EYES = 1.5
"""Eyes that are open wider than so many times the average squint and look down no farther for it."""


@dataclass(frozen=True)
class IdentitySpace:
    """Faces as neutral + sum_c a_c modes_c, the a_c independent with unit variance among people."""

    modes: Float[np.ndarray, "c n 3"]
    """Millimetres a standard deviation, strongest first; each is symmetric or antisymmetric."""

    def displacement(self, coefficients: Float[np.ndarray, " c"]) -> Float[np.ndarray, "n 3"]:
        """Sum of the modes under `coefficients`, in standard deviations; fewer than all are the first ones.

        Raises:
            ValueError: more coefficients than modes.
        """
        if len(coefficients) > len(self.modes):
            raise ValueError(f"coefficients: expected at most {len(self.modes)}, got {len(coefficients)}")
        return np.tensordot(coefficients, self.modes[: len(coefficients)], axes=1)


@dataclass(frozen=True)
class BundledFace:
    """An average adult head with the ARKit expressions (MakeHuman's data, CC0; see `assets/README.md`).

    Face space: millimetres, +Y up, +Z out of the face, +X to the subject's left. The origin lies on the mirror plane
    at the height of the eyeballs' centres, 80 mm behind them: about the middle of the head, between the ears' tops.
    """

    rig: Rig
    """The average adult and the 52 ARKit shapes. `mouthClose` corrects `jawOpen` and means nothing by itself: weigh it
    no more than `jawOpen`."""
    identity: IdentitySpace
    mirror: Int[np.ndarray, " n"]
    """The vertex at -x of each vertex; those on the mirror plane are their own. Exact on the neutral."""
    parts: dict[str, Int[np.ndarray, " _"]]
    """Vertices of skin, left_eye, right_eye, upper_teeth, lower_teeth, tongue: every vertex is in one."""
    regions: dict[str, Float[np.ndarray, " n"]]
    """Smooth masks in 0..1 by name; 0 off the outer skin."""
    contours: dict[str, Int[np.ndarray, " _"]]
    """Vertices along left_upper_lid, left_lower_lid, right_..., upper_lip, lower_lip: the edges of the openings,
    from corner to corner by increasing x. Empty for a rig from elsewhere, whose shapes are taken as they are."""

    def __repr__(self) -> str:
        return one_line(self, self.rig)

    @cached_property
    def on_skin(self) -> Bool[np.ndarray, " n"]:
        """Whether a vertex is the skin's, inside of the mouth and backs of the lids too."""
        return np.isin(np.arange(len(self.rig.neutral.vertices)), self.parts["skin"])

    @property
    def skin_faces(self) -> Int[np.ndarray, " f"]:
        """The skin's triangles."""
        return np.flatnonzero(self.on_skin[self.rig.neutral.faces].all(axis=1))

    def person(self, coefficients: Float[np.ndarray, " c"]) -> Rig:
        """Another person's rig: the identity's neutral with the average's expressions, fitted to the eyes.

        Displacements are the average's but for the eyes: eyeballs turn about their own centres, and the lids'
        travel is fitted to the opening (`faces/lids.py`), so that a blink closes it and a squint does not overshoot.
        """
        vertices = self.rig.neutral.vertices + self.identity.displacement(coefficients)
        neutral = self.rig.neutral.with_vertices(vertices)
        return self.rig.with_shapes(neutral, self.fitted_deltas(vertices))

    def eyeball(self, vertices: Float[np.ndarray, "n 3"], side: str) -> tuple[Float[np.ndarray, " 3"], float]:
        """Centre (3,) and radius, mm, of the `left` or `right` eyeball of a face in this topology."""
        front, back = vertices[self.parts[f"{side}_eye"][[0, -1]]]
        return (front + back) / 2, float(np.linalg.norm(front - back) / 2)

    def fitted_deltas(self, vertices: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "shapes n 3"]:
        """The 52 displacements (52, n, 3), mm, with eyes and lids fitted to the neutral face `vertices`."""
        deltas = self.rig.deltas.copy()
        if not self.contours:
            return deltas
        for side in ("left", "right"):
            lids = self.contours[f"{side}_upper_lid"], self.contours[f"{side}_lower_lid"]
            (centre, radius), (_, usual) = self.eyeball(vertices, side), self.eyeball(self.rig.neutral.vertices, side)
            ratio = opening(vertices, *lids) / opening(self.rig.neutral.vertices, *lids)
            end, ball = side.capitalize(), self.parts[f"{side}_eye"]
            for name in ("eyeLookDown", "eyeSquint"):
                deltas[self.rig.index(name + end)] *= 1 + self.regions["eyes"][:, None] * (min(ratio, WIDEST_EYES) - 1)
            for name in ("eyeLookUp", "eyeLookDown", "eyeLookIn", "eyeLookOut"):
                k = self.rig.index(name + end)
                deltas[k, ball] = self.rig.deltas[k, ball] * radius / usual
            blink = self.rig.index("eyeBlink" + end)
            deltas[blink] = fit_blink(vertices, self.rig.deltas[blink], *lids, centre)
        return deltas


@cache
def load_face() -> BundledFace:
    """The bundled face. Read once a process; treat the arrays as read-only."""
    with np.load(Path(__file__).parent / "assets" / "face.npz") as data:
        a = dict(data)
    n = len(a["neutral"])
    neutral = Mesh(
        vertices=a["neutral"].astype(np.float64), faces=a["faces"].astype(np.int32),
        uv=a["uv"] / 65535.0, uv_faces=a["uv_faces"].astype(np.int32), colors=a["colors"] / 255.0,
    )  # fmt: skip
    rig = Rig(neutral, a["deltas"].reshape(-1, n, 3) * float(a["delta_step"]), tuple(a["names"].tolist()))
    parts = {str(name): np.flatnonzero(a["part"] == i) for i, name in enumerate(a["part_names"])}
    regions = {str(name): mask / 255.0 for name, mask in zip(a["region_names"], a["regions"], strict=True)}
    contours = {key.removeprefix("contour_"): v.astype(np.int64) for key, v in a.items() if key.startswith("contour_")}
    modes = a["modes"] * float(a["mode_step"])
    return BundledFace(rig, IdentitySpace(modes), a["mirror"].astype(np.int64), parts, regions, contours)
